// Random contacts of two spheres with friction, as a cluster and by the general method of an isolated contact: prints
// how many were compared, how many did not end, the largest difference of velocities and spins, and the largest errors
// of the balances of energy and angular momentum. First under a viscoelastic law, then under a linear one, by series
// (turning_step.hpp), stopped at a random time and continued, with a third body near.
#include <cstdio>
#include <random>

#include "boxes/binary_contact/turning_contact.hpp"
#include "boxes/newton_events/cluster/cluster.hpp"
#include "contact/linear_dashpot.hpp"
#include "contact/viscoelastic.hpp"

namespace {

using namespace hardlimit;
using namespace hardlimit::boxes;
using contact::LinearDashpot;
using contact::Viscoelastic;

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
template <class Normal>
struct Contact {
    WithFriction<Normal> law;
    TurningApproach touch;
};
TurningApproach any_touch() {
    TurningApproach a{1.0, 1.0, 1.0, decades(1.0, 8.0), {0.0, 0.0, 1.0}, {}, {}};
    a.velocity = any_vector(any_of({0.0, 1e-6, 0.1, 0.3, 1.0, 3.0}));
    a.velocity[2] = -1.0;
    a.spin = any_vector(any_of({0.0, 1e-8, 0.1, 1.0, 10.0}));
    return a;
}
Contact<Viscoelastic> any_contact(Viscoelastic normal) {
    const double duration = decades(1e-5, 0.3);
    normal.elastic_prefactor = math::pow(3.2 / duration, 2.5);
    normal.dissipative_time = any_of({0.0, 1e-6, 0.03, 0.1, 0.3}) * duration;
    Friction f{.coefficient = any_of({0.05, 0.1, 0.5, 1.5})};
    f.model = any_of({FrictionModel::mindlin, FrictionModel::mindlin_force, FrictionModel::mindlin_rescale,
                      FrictionModel::mindlin_rescale_force});
    f.stiffness_ratio = decades(0.05, 3.0);
    f.damping_ratio = any_of({0.0, 0.5, 1.0});
    const TurningApproach a = any_touch();
    return {{normal, friction_terms(f, Viscoelastic::record.powers, normal.coefficients())}, a};
}
Contact<LinearDashpot> any_contact(LinearDashpot normal) {
    const double part = decades(1e-5, 0.3), restitution = any_of({1.0, 1.0 - 1e-6, 0.9, 0.6, 0.3, 0.05});
    normal = LinearDashpot::from_damping_ratio((math::pi / part) * (math::pi / part),
                                               contact::linear_damping_ratio(-math::log(restitution)), 1.0);
    FrictionTerms f{.coefficient = any_of({0.05, 0.1, 0.5, 1.5, math::infinity})};
    f.stiffness = {decades(0.05, 3.0) * normal.stiffness, 0};
    f.damping = {any_of({0.0, 0.0, 0.5, 1.0}) * normal.damping, 0};
    if (f.damping.factor == 0.0 && uniform() < 0.3) f.limit = SlipLimit::spring;
    TurningApproach a = any_touch();
    if (uniform() < 0.2) a.velocity[1] = a.spin[0] = a.spin[2] = 0.0;  // in a plane
    return {{normal, f}, a};
}

// Two spheres that touch at time 0, and a third one near them.
template <class Normal>
Cluster<WithFriction<Normal>> two_spheres(const Contact<Normal>& c, bool equal) {
    Cluster<WithFriction<Normal>> cluster;
    cluster.clear();
    const auto part = [equal] { return equal ? 0.5 : 0.1 + 0.8 * uniform(); };
    const double mass = part(), radius = 0.5, spin = part(), inertia = part();
    for (const bool second : {false, true}) {
        const double of_spin = second ? 1.0 - spin : spin, of_inertia = second ? 1.0 - inertia : inertia;
        const double share = second ? 1.0 - mass : -mass;
        cluster.members.push_back(
            {1.0 / math::abs(share), radius, {0.0, 0.0, second ? 1.0 : 0.0}, share * c.touch.velocity});
        cluster.rotations.push_back(
            {radius * radius / (c.touch.rotational_ratio * of_inertia), (of_spin / radius) * c.touch.spin});
    }
    ContactPair<WithFriction<Normal>> q{};
    q.first = 0, q.second = 1;
    q.mass = q.contact_distance = 1.0;
    q.law = c.law;
    cluster.pairs.push_back(q);
    cluster.largest_coordinate = 1.0;
    if (equal) return cluster;
    cluster.members.push_back({1.0, radius, {0.0, 1000.0, 0.0}, {}});
    cluster.rotations.push_back({1.0, {}});
    q.first = 2;
    cluster.pairs.push_back(q);
    cluster.gravity = {0.3, -0.2, 0.1};
    return cluster;
}

template <class Law>
double energy(const Cluster<Law>& c) {
    double sum = c.dissipated;
    for (std::size_t i = 0; i < 2; ++i) {
        const Member& m = c.members[i];
        sum += m.mass * (0.5 * dot(m.velocity, m.velocity) - dot(c.gravity, m.position)) +
               0.5 * c.rotations[i].inertia * dot(c.rotations[i].spin, c.rotations[i].spin);
    }
    return sum;
}
// Of the relative motion and of the spins.
template <class Law>
Vector3 angular_momentum(const Cluster<Law>& c) {
    const Member &a = c.members[0], &b = c.members[1];
    Vector3 sum = cross(b.position - a.position, b.velocity - a.velocity);
    for (std::size_t i = 0; i < 2; ++i) sum = sum + c.rotations[i].inertia * c.rotations[i].spin;
    return sum;
}

template <class Normal>
void compare(int contacts) {
    const bool equal = Normal::onset_power > 1;
    int compared = 0, unresolved = 0;
    double largest = 0.0, unbalanced = 0.0, turned = 0.0;
    for (int i = 0; i < contacts; ++i) {
        const Contact<Normal> c = any_contact(Normal{});
        const TurningContact alone = TurningSolver<Normal>(c.law, c.touch).integrate([](const auto&) {});
        if (alone.outcome != Outcome::ok) continue;
        auto cluster = two_spheres(c, equal);
        const double before = energy(cluster);
        const Vector3 swing = angular_momentum(cluster);
        if (!equal) cluster.run_through(uniform() * alone.duration);
        cluster.run_through(1.5 * alone.duration);
        ++compared, unresolved += cluster.unresolved || cluster.ended.size() != 1;
        const auto& spun = cluster.rotations;
        const Vector3 velocity = cluster.members[1].velocity - cluster.members[0].velocity,
                      spin = 0.5 * (spun[0].spin + spun[1].spin);
        const double off = math::max(size(velocity - alone.velocity), size(spin - alone.spin)),
                     unit = size(c.touch.velocity) + size(c.touch.spin);
        largest = math::max(largest, off / unit);
        unbalanced = math::max(unbalanced, math::abs(energy(cluster) - before) / (unit * unit));
        turned = math::max(turned, size(angular_momentum(cluster) - swing) / unit);
    }
    std::printf("%d %d %.3g %.3g %.3g\n", compared, unresolved, largest, unbalanced, turned);
}

}  // namespace

int main() {
    compare<Viscoelastic>(400);
    compare<LinearDashpot>(1000);
}
