// Program for test_friction_by_events.py: a box as one cluster, from touch to touch. Reads numbers: edges (x, y; 0
// where the box is periodic), gravity along y, time of the end, k, ε, k_t, γ_t, μ, number of bodies; for each body
// radius, mass, inertia, position, velocity and spin in the plane. Prints a row for each contact: its begin, first and
// second body, or wall, and how often the surfaces changed between stick and slip.
#include <cstdio>
#include <vector>

#include "boxes/newton_events/cluster/cluster.hpp"
#include "contact/linear_dashpot.hpp"

using namespace hardlimit;
using namespace hardlimit::boxes;
using Normal = contact::LinearDashpot;
using Law = WithFriction<Normal>;

namespace {

double next() {
    double x = math::nan;
    return std::scanf("%lf", &x) == 1 ? x : math::nan;
}

struct Contact {
    double stiffness, restitution;
    FrictionTerms friction;

    Law between(double effective_mass) const {
        const double ratio = contact::linear_damping_ratio(-math::log(restitution));
        return {Normal::from_damping_ratio(stiffness, ratio, effective_mass), friction};
    }
};

void add(Cluster<Law>& cluster, const Contact& contact, ContactPair<Law> q, double mass, double distance) {
    q.mass = mass, q.contact_distance = distance, q.law = contact.between(mass);
    if (cluster.gap(q) < 0.0)
        q.state = ContactState::closed, q.surfaces.start = PairSurfaces<Law>::Start::jump;
    cluster.pairs.push_back(q);
}

}  // namespace

int main() {
    Cluster<Law> cluster;
    cluster.clear();
    const double edge[2] = {next(), next()};
    cluster.gravity = {0.0, next(), 0.0};
    cluster.planar = true;
    cluster.largest_coordinate = 0.1;
    const double until = next();
    Contact contact{};
    contact.stiffness = next(), contact.restitution = next();
    contact.friction.stiffness.factor = next(), contact.friction.damping.factor = next();
    contact.friction.coefficient = next();
    const int count = static_cast<int>(next());
    for (int i = 0; i < count; ++i) {
        Member m{};
        m.radius = next(), m.mass = next();
        const double inertia = next();
        for (double* x : {&m.position[0], &m.position[1], &m.velocity[0], &m.velocity[1]}) *x = next();
        cluster.members.push_back(m);
        cluster.rotations.push_back({inertia, {0.0, 0.0, next()}});
    }
    for (int i = 0; i < count; ++i) {
        const Member& a = cluster.members[static_cast<std::size_t>(i)];
        for (int j = i + 1; j < count; ++j) {
            const Member& b = cluster.members[static_cast<std::size_t>(j)];
            ContactPair<Law> q{};
            q.first = i, q.second = j;
            add(cluster, contact, q, effective(a.mass, b.mass), a.radius + b.radius);
        }
        for (int axis = 0; axis < 2; ++axis)
            for (const bool high : {false, true}) {
                if (!(edge[axis] > 0.0)) continue;
                ContactPair<Law> q{};
                q.first = i, q.second = -1, q.wall_id = WallId::at(axis, high), q.axis = axis;
                q.side = high ? -1.0 : 1.0, q.wall = high ? edge[axis] : 0.0;
                add(cluster, contact, q, a.mass, a.radius);
            }
    }
    cluster.run_through(until);
    const auto row = [&](const ContactPair<Law>& q, double begin, int changes) {
        std::printf("%.17g %d %d %d\n", begin, q.first, q.second < 0 ? q.wall_id.number : q.second, changes);
    };
    for (const EndedContact& e : cluster.ended)
        row(cluster.pairs[static_cast<std::size_t>(e.pair)], e.begin, e.changes);
    for (const ContactPair<Law>& q : cluster.pairs)
        if (q.state == ContactState::closed) row(q, q.begin, q.surfaces.changes);
    return cluster.unresolved || cluster.too_deep >= 0;
}
