// Program for test_newton_events.py: the parts of a cluster, each alone, for random networks of touching spheres at a
// wall. Prints
//   the largest relative rate of momentum and of energy that the equations create,
//   the number of components of the state vectors, and of those that no quantity or several have,
//   the number of values that differ after a state is loaded, gets other coordinates and is stored, and
//   the largest distance of the surfaces, in radii, at the time that the flight of a pair predicts for touch.
#include "boxes/newton_events/cluster/equations.hpp"
#include "boxes/newton_events/cluster/flight.hpp"
#include "contact/viscoelastic.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

using namespace hardlimit;
using namespace hardlimit::boxes;
using Law = contact::Viscoelastic;
using Network = ContactNetwork<Law>;

namespace {

constexpr double pi = 3.14159265358979, radius = 1e-3;

ContactPair<Law> pair_of(Network& network, int first, int second) {
    ContactPair<Law> q{};
    const double a = network.members[first].mass,
                 b = second < 0 ? math::infinity : network.members[second].mass;
    q.first = first, q.second = second;
    q.wall_id = second < 0 ? WallId::at(2, false) : WallId{};
    q.axis = 2, q.side = 1.0;
    q.wall_velocity = second < 0 ? 0.02 : 0.0;
    q.contact_distance = second < 0 ? radius : 2.0 * radius;
    q.mass = effective(a, b);
    q.law = Law{1e5, 1e-5};
    const ContactGeometry g = network.geometry(q);
    if (g.depth > q.law.slack(g.rate).depth) q.state = ContactState::closed;
    return q;
}

// A chain of spheres along a line above the wall; the first one touches it.
Network random_network(std::mt19937& engine, double spacing) {
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    Network network;
    network.gravity = {0.0, 0.0, -9.81};
    for (int i = 0; i < 5; ++i) {
        Member m{
            4.0 / 3.0 * pi * radius * radius * radius * (2000.0 + 500.0 * uniform(engine)), radius, {}, {}};
        m.position = {1e-4 * uniform(engine), 1e-4 * uniform(engine), radius * spacing * (1.0 + 2.0 * i)};
        for (double& v : m.velocity) v = 0.1 * uniform(engine);
        network.members.push_back(m);
    }
    for (int i = 0; i < 5; ++i)
        for (int j = i + 1; j < 5; ++j) network.pairs.push_back(pair_of(network, i, j));
    network.pairs.push_back(pair_of(network, 0, -1));
    return network;
}

std::vector<int> closed_pairs(const Network& network) {
    std::vector<int> closed;
    for (int q = 0; q < static_cast<int>(network.pairs.size()); ++q)
        if (network.pairs[q].state == ContactState::closed) closed.push_back(q);
    return closed;
}

}  // namespace

int main() {
    std::mt19937 engine(1);
    double momentum = 0.0, energy = 0.0, gap = 0.0;
    int components = 0, misplaced = 0, changed = 0;
    for (int run = 0; run < 200; ++run) {
        Network network = random_network(engine, 0.98);
        Ledger ledger;
        ledger.dissipated = 1.0, ledger.wall_work = 2.0, ledger.walls.impulse[4] = 3.0;
        const Scales scales(network);
        scales.set_active(network, 0.0);
        StateVector state;
        state.load(network, ledger);
        state.choose_roots(network, closed_pairs(network));
        const StateLayout& at = state.layout;

        std::vector<int> owners(at.size());
        const auto own = [&](int first, int count) {
            for (int c = first; c < first + count; ++c) ++owners[c];
        };
        for (int i = 0; i < at.members(); ++i) own(at.position(i), 3), own(at.velocity(i), 3);
        for (const int c : {at.time(), at.loss(), at.wall_work()}) own(c, 1);
        for (const int q : at.rooted()) own(at.root(q), 1);
        own(at.virial(), 6), own(at.wall_sums(WallId::at(2, false)), 2);
        components += at.size();
        misplaced +=
            static_cast<int>(std::count_if(owners.begin(), owners.end(), [](int n) { return n != 1; }));

        std::vector<double> slope(at.size());
        Equations<Law>{network, at}(state.y.data(), slope.data());
        const double clock = slope[at.time()];
        double power = slope[at.loss()] - slope[at.wall_work()], scale = 0.0, push = 0.0, pushed = 0.0;
        for (int i = 0; i < at.members(); ++i)
            for (int a = 0; a < 3; ++a) {
                const double m = network.members[i].mass, v = state.y[at.velocity(i) + a];
                const double force = m * (slope[at.velocity(i) + a] - clock * network.gravity[a]);
                power += v * force, scale += std::abs(v * force);
                if (a == 2) push += force, pushed += std::abs(force);
            }
        for (const int q : at.rooted()) {
            const double s = state.y[at.root(q)];
            power += network.pairs[q].law.elastic_force(s) * 2.0 * s * slope[at.root(q)];
        }
        push -= slope[at.wall_sums(WallId::at(2, false))];
        momentum = std::max(momentum, std::abs(push) / pushed);
        energy = std::max(energy, std::abs(power) / scale);

        const Network before = network;
        const Ledger kept = ledger;
        state.choose_roots(network, {});
        state.store(network, ledger);
        for (std::size_t i = 0; i < network.members.size(); ++i)
            changed += network.members[i].position != before.members[i].position ||
                       network.members[i].velocity != before.members[i].velocity;
        changed += ledger.dissipated != kept.dissipated || ledger.wall_work != kept.wall_work ||
                   ledger.walls.impulse[4] != kept.walls.impulse[4];

        Network apart = random_network(engine, 1.02);
        for (const ContactPair<Law>& q : apart.pairs) {
            state.load(apart, ledger);
            const double time = PairFlight<Law>(state.at(apart), q).time_to_touch();
            if (!(time < 1.0)) continue;
            for (Member& m : apart.members)
                for (int a = 0; a < 3; ++a) {
                    m.position[a] += time * (m.velocity[a] + 0.5 * time * apart.gravity[a]);
                    m.velocity[a] += time * apart.gravity[a];
                }
            apart.time = time;
            gap = std::max(gap, std::abs(apart.gap(q)) / radius);
            break;
        }
    }
    std::printf("%g %g %d %d %d %g\n", momentum, energy, components, misplaced, changed, gap);
}
