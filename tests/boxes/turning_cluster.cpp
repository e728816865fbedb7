// Random contacts of two viscoelastic spheres with friction, as a cluster and by the general method of an isolated
// contact: prints how many were compared, how many did not end, and the largest difference of velocities and spins.
#include <cstdio>
#include <random>

#include "boxes/binary_contact/turning_contact.hpp"
#include "boxes/newton_events/cluster/cluster.hpp"
#include "contact/viscoelastic.hpp"

namespace {

using namespace hardlimit;
using namespace hardlimit::boxes;
using Normal = contact::Viscoelastic;
using Law = WithFriction<Normal>;

std::mt19937_64 bits(1);
double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
double decades(double least, double most) { return least * math::exp(uniform() * math::log(most / least)); }
template <class T, std::size_t n>
T any_of(const T (&values)[n]) {
    return values[static_cast<std::size_t>(uniform() * n)];
}
Vector3 any_vector(double size) {
    Vector3 x;
    for (double& c : x) c = size * (2.0 * uniform() - 1.0);
    return x;
}
double size(const Vector3& a) { return math::sqrt(dot(a, a)); }

// The normal speed, the effective mass and the distance at touch are 1.
struct Contact {
    Law law;
    TurningApproach touch;
};
Contact any_contact() {
    const double duration = decades(1e-5, 0.3);
    Normal normal{};
    normal.elastic_prefactor = math::pow(3.2 / duration, 2.5);
    normal.dissipative_time = any_of({0.0, 1e-6, 0.03, 0.1, 0.3}) * duration;
    Friction f{.coefficient = any_of({0.05, 0.1, 0.5, 1.5})};
    f.model = any_of({FrictionModel::mindlin, FrictionModel::mindlin_force, FrictionModel::mindlin_rescale,
                      FrictionModel::mindlin_rescale_force});
    f.stiffness_ratio = decades(0.05, 3.0);
    f.damping_ratio = any_of({0.0, 0.5, 1.0});
    TurningApproach a{1.0, 1.0, 1.0, decades(1.0, 8.0), {0.0, 0.0, 1.0}, {}, {}};
    a.velocity = any_vector(any_of({0.0, 1e-6, 0.1, 0.3, 1.0, 3.0}));
    a.velocity[2] = -1.0;
    a.spin = any_vector(any_of({0.0, 1e-8, 0.1, 1.0, 10.0}));
    return {{normal, friction_terms(f, Normal::record.powers, normal.coefficients())}, a};
}

// Two equal spheres that touch at time 0.
Cluster<Law> by_cluster(const Contact& c, double until) {
    Cluster<Law> cluster;
    cluster.clear();
    for (const double side : {-0.5, 0.5}) {
        cluster.members.push_back({2.0, 0.5, {0.0, 0.0, 0.5 + side}, side * c.touch.velocity});
        cluster.rotations.push_back({0.5 / c.touch.rotational_ratio, c.touch.spin});
    }
    ContactPair<Law> q{};
    q.first = 0, q.second = 1;
    q.mass = q.contact_distance = 1.0;
    q.law = c.law;
    cluster.pairs.push_back(q);
    cluster.largest_coordinate = 1.0;
    cluster.run_through(until);
    return cluster;
}

}  // namespace

int main() {
    int compared = 0, unresolved = 0;
    double largest = 0.0;
    for (int i = 0; i < 400; ++i) {
        const Contact c = any_contact();
        const TurningContact alone =
            TurningSolver<Law::Frictionless>(c.law, c.touch).integrate([](const auto&) {});
        if (alone.outcome != Outcome::ok) continue;
        const Cluster<Law> cluster = by_cluster(c, 1.5 * alone.duration);
        ++compared, unresolved += cluster.unresolved || cluster.ended.size() != 1;
        const Vector3 velocity = cluster.members[1].velocity - cluster.members[0].velocity;
        const double off =
            math::max(size(velocity - alone.velocity), size(cluster.rotations[0].spin - alone.spin));
        largest = math::max(largest, off / (size(c.touch.velocity) + size(c.touch.spin)));
    }
    std::printf("%d %d %.3g\n", compared, unresolved, largest);
}
