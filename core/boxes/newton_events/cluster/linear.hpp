// A step of a cluster under a linear law: a power series in time (kernels/power_series.hpp), with events at zeros of
// polynomials.
#pragma once
#include <array>
#include <utility>

#include "../../kernels/power_series.hpp"
#include "events.hpp"

namespace hardlimit::boxes {

// The motion of all members and of all overlapping pairs as power series around the present state. In the unit of time
// the fastest contact or sine has angular frequency 1.
class Expansion {
public:
    WorkVector<series::Path> path;         // [members]
    WorkVector<series::Contact> contacts;  // overlapping pairs
    double unit = 0.0;                     // of time [s]

    template <class Law>
    void expand(const ContactNetwork<Law>& network, const StateVector& state,
                const hardlimit_abi::SeriesKernels& kernels) {
        const StateLayout& at = state.layout;
        kernels_ = &kernels;
        unit = unit_of(network);
        path.resize(network.members.size());
        for (int i = 0; i < at.members(); ++i) {
            const double *x = &state.y[at.position(i)], *v = &state.y[at.velocity(i)];
            path[i][0] = series::Four{x[0], x[1], x[2], 0.0};
            path[i][1] = series::Four{v[0], v[1], v[2], 0.0} * unit;
        }
        contacts.clear();
        for (int q = 0; q < static_cast<int>(network.pairs.size()); ++q)
            if (network.pairs[q].state != ContactState::open) add_contact(network, q, state.time());
        order_bodies();
        kernels.expand(path.data(), at.members(), contacts.data(), static_cast<int>(contacts.size()),
                       gravity4(network).data(), unit);
    }

    const hardlimit_abi::SeriesKernels& kernels() const { return *kernels_; }

    // Step for which the last two terms of the series are about as small as the tolerance, in units of time.
    template <class Law>
    double longest_step(const ContactNetwork<Law>& network, double tolerance) const {
        static_assert(series::order == 16);
        double depth = math::infinity, far = 0.0;
        for (const ContactPair<Law>& q : network.pairs)
            if (q.state == ContactState::closed) depth = math::min(depth, q.depth_unit);
        for (const series::Path& x : path) far = math::max(far, series::largest(x[0]));
        const double allowed = math::max(0.1 * tolerance * depth, math::epsilon * far);
        const double most = kernels_->last_terms(path.data(), body_order_.data(), in_contact_);
        return most > 0.0 ? math::sqrt(math::sqrt(math::sqrt(math::sqrt(allowed / most)))) : math::infinity;
    }

    // Computes the largest distance that each member covers within a step.
    const double* travel(double step) {
        travel_.resize(path.size());
        kernels_->travel(path.data(), body_order_.data(), in_contact_, static_cast<int>(path.size()), step,
                         travel_.data());
        return travel_.data();
    }

    // The coordinate of the wall of a pair.
    template <class Law>
    void expand_wall(const ContactNetwork<Law>& network, const ContactPair<Law>& q, double now,
                     series::Terms& wall) const {
        if (boxes_move && !network.wall_pieces.empty())
            return network.piece(q).expand(now, unit, series::order, wall.of);
        wall = {{q.wall_position(now), q.wall_velocity * unit}};
    }

    // Advances the state to a time within the step. `chord_deviation` [members], or null.
    template <class Law>
    void advance(const ContactNetwork<Law>& network, double step, StateVector& state,
                 double* chord_deviation) const {
        const StateLayout& at = state.layout;
        kernels_->move(path.data(), body_order_.data(), in_contact_, at.members(), contacts.data(),
                       static_cast<int>(contacts.size()), step, unit, gravity4(network).data(),
                       state.y.data(), &state.y[at.loss()], &state.y[at.virial()], chord_deviation);
        for (const series::Contact& f : contacts) {
            if (!f.closed || f.second >= 0) continue;
            double impulse = 0.0, lost = 0.0;  // of the force on the body, over the unit of time; dissipated
            for (int k = series::order; k >= 0; --k)
                impulse = (impulse + f.force[static_cast<std::size_t>(k)] / (k + 1)) * step;
            const bool uniform = network.wall_pieces.empty();
            const double work = f.side * (uniform ? impulse * f.wall[1] : work_on_wall(f, step));
            if (at.walls_move()) state.y[at.wall_work()] += work;
            series::add_integrals(f, step, unit, &lost, nullptr);
            double* const given = &state.y[at.wall_sums(network.pairs[f.pair].wall_id)];
            given[0] += impulse * unit, given[1] += lost - work;
        }
        state.time() += step * unit;
    }

private:
    template <class Law>
    static double unit_of(const ContactNetwork<Law>& network) {
        double square = 0.0;
        for (const ContactPair<Law>& q : network.pairs)
            if (q.state == ContactState::closed)
                square = math::max(square, q.law.elastic_force(1.0) / q.mass);
        for (const WallPiece& p : network.wall_pieces) square = math::max(square, p.omega * p.omega);
        return 1.0 / math::sqrt(square);
    }
    template <class Law>
    static std::array<double, 4> gravity4(const ContactNetwork<Law>& network) {
        return {network.gravity[0], network.gravity[1], network.gravity[2], 0.0};
    }

    template <class Law>
    void add_contact(const ContactNetwork<Law>& network, int index, double now) {
        const ContactPair<Law>& q = network.pairs[index];
        series::Contact& f = contacts.emplace_back();
        f.pair = index;
        f.first = q.first;
        f.second = q.second;
        f.axis = q.axis;
        f.closed = q.state == ContactState::closed;
        f.side = q.side;
        if (q.second < 0) expand_wall(network, q, now, f.wall);
        f.image = series::Four{q.image[0], q.image[1], q.image[2], 0.0};
        f.contact_distance = f.bodies.contact_distance = q.contact_distance;
        f.spring = f.bodies.spring = q.law.elastic_force(1.0);
        f.damper = f.bodies.damper = q.law.force(0.0, 1.0) / unit;
        f.per_mass[0] = 1.0 / network.members[q.first].mass;
        f.per_mass[1] = q.second < 0 ? 0.0 : 1.0 / network.members[q.second].mass;
    }

    // Orders the members: those in contact, then the others.
    void order_bodies() {
        const int count = static_cast<int>(path.size());
        body_order_.clear();
        is_ordered_.assign(path.size(), 0);
        const auto add = [&](int body) {
            if (!std::exchange(is_ordered_[body], 1)) body_order_.push_back(body);
        };
        for (const series::Contact& f : contacts) {
            add(f.first);
            if (f.second >= 0) add(f.second);
        }
        in_contact_ = static_cast<int>(body_order_.size());
        if (in_contact_ == count) return;
        for (int i = 0; i < count; ++i) add(i);
    }

    // ∫ F dx_wall up to a time within the step, in units of the series.
    static double work_on_wall(const series::Contact& f, double step) {
        double sum = 0.0;
        for (int n = series::order; n >= 0; --n) {
            double term = 0.0;
            for (int k = 0; k < n; ++k)
                term += f.force[static_cast<std::size_t>(n - 1 - k)] * (k + 1) *
                        f.wall[static_cast<std::size_t>(k + 1)];
            sum = sum * step + (n > 0 ? term / n : 0.0);
        }
        return sum;
    }

    const hardlimit_abi::SeriesKernels* kernels_ = nullptr;
    WorkVector<int> body_order_;   // [members] those in contact, then the others
    WorkVector<char> is_ordered_;  // [members]
    WorkVector<double> travel_;    // [members]
    int in_contact_ = 0;           // number of members in contact
};

// A step up to the first event of a pair.
template <class Law>
struct SeriesStep {
    ContactNetwork<Law>& network;
    StateVector& state;
    const Scales& scales;
    Ledger& ledger;
    Expansion& expansion;
    const double tolerance;           // of a step, relative to the unit of length
    const double largest_coordinate;  // for the rounding error of positions [m]
    double longest = 0.0;             // at most 1 [units of the series]
    double end = 0.0;                 // of the step, at the first event so far [units of the series]
    PairEvent event{};                // there

    // `trajectory`: receives the chord deviations, or null.
    Progress take(double until, const hardlimit_abi::SeriesKernels& kernels, Trajectory* trajectory) {
        scales.set_active(network, ledger.largest_compression);
        const auto value = [&](int q, ContactEvent kind) {
            return event_value(state.at(network), network.pairs[q], kind);
        };
        if (const PairEvent now = event_at_start(network, state, scales, value)) return {.event = now};
        expansion.expand(network, state, kernels);
        const double rest = (until - state.time()) / expansion.unit;
        const double step = expansion.longest_step(network, tolerance);
        longest = math::min(step, 1.0);
        end = math::min(step, rest);
        for (const series::Contact& f : expansion.contacts) predict_end(f);
        if (expansion.contacts.size() < network.pairs.size()) predict_begins();
        for (const series::Contact& f : expansion.contacts) record_compressions(f);
        expansion.advance(network, end, state,
                          trajectory ? trajectory->next_deviations(network.members.size()) : nullptr);
        if (rest <= step && !event) state.time() = until;
        open_pairs();
        for (int q = 0; q < static_cast<int>(network.pairs.size()); ++q)
            if (network.pairs[q].fresh && !(event && event.pair == q))
                network.pairs[q].fresh = lies_on_surface(network.pairs[q]);
        return {.moved = true, .event = event};
    }

private:
    bool lies_on_surface(const ContactPair<Law>& q) const {
        for (const ContactEvent kind : next_events(q))
            if (kind != ContactEvent::none && !(event_value(state.at(network), q, kind) > 0.0)) return true;
        return false;
    }

    // Predicts when a closed contact ends or becomes too deep, or a slack pair engages. The instant at which a slack
    // pair opens does not matter, as it exerts no force.
    void predict_end(const series::Contact& f) {
        const auto minus = [](series::Terms terms) {
            for (double& x : terms.of) x = -x;
            return terms;
        };
        if (!f.closed) return consider(f.pair, ContactEvent::engages, minus(f.force_series()), f.spring);
        consider(f.pair, ContactEvent::ends, f.force_series(), f.spring);
        const ContactPair<Law>& q = network.pairs[f.pair];
        if (!q.may_be_too_deep) return;
        series::Terms left = f.second < 0 ? minus(f.depth) : f.bodies.distance;
        left[0] = depth_left(network, q, state.at(network).geometry(q));
        consider(f.pair, ContactEvent::deepens, left, 1.0);
    }

    void predict_begins() {
        const double* travel = expansion.travel(end);
        for (int q = 0; q < static_cast<int>(network.pairs.size()); ++q)
            if (network.pairs[q].state == ContactState::open) predict_begin(q, travel);
    }

    // `travel` [members]: largest distance covered within the step.
    void predict_begin(int index, const double* travel) {
        const ContactPair<Law>& q = network.pairs[index];
        const ContactGeometry g = state.at(network).geometry(q);
        const WorkVector<series::Path>& path = expansion.path;
        series::Terms gap;
        if (q.second < 0) {
            expansion.expand_wall(network, q, state.time(), gap);
            double covered = 0.0;  // at most by the wall
            for (int n = series::order; n >= 1; --n)
                covered = (covered + math::abs(gap[static_cast<std::size_t>(n)])) * end;
            if (-g.depth > travel[q.first] + covered) return;
            for (std::size_t n = 0; n < series::length; ++n)
                gap[n] = q.side * (path[q.first][n][q.axis] - gap[n]);
            gap[0] = -g.depth;
        } else {
            if (-g.depth > travel[q.first] + travel[q.second]) return;
            expansion.kernels().square(&path[q.first], &path[q.second], q.image.data(), gap.of);
            gap[0] = -g.depth * (g.distance + q.contact_distance);
        }
        consider(index, ContactEvent::begins, gap, q.second < 0 ? 1.0 : q.contact_distance);
    }

    // Keeps the first zero of f if it is the earliest event so far. `unit`: change of f per distance.
    void consider(int index, ContactEvent kind, const series::Terms& f, double unit) {
        const ContactPair<Law>& q = network.pairs[index];
        const hardlimit_abi::SeriesKernels& kernels = expansion.kernels();
        const auto farthest = [&](int body) { return series::largest(expansion.path[body][0]); };
        // The event function of a fresh pair differs from zero by the rounding error of the positions, which is large
        // in a large box or far from the origin of a large cluster.
        double far = math::max(math::max(q.contact_distance, largest_coordinate), farthest(q.first));
        if (q.second >= 0) far = math::max(far, farthest(q.second));
        const double rounding = 4.0 * math::epsilon * far * unit;
        double zero =
            q.fresh ? kernels.next_zero(f.of, end, longest, rounding) : kernels.first_zero(f.of, end);
        // A force that is pure rounding may fall through damping without an end of the contact: without damping it
        // would rise at once.
        if (zero == 0.0 && kind != ContactEvent::begins && f[0] > 0.0) zero = kernels.first_zero(f.of, end);
        if (zero <= end) end = zero, event = {kind, index};
    }

    // Updates the largest compression of a pair within the step. If its rate falls through zero, Newton's method finds
    // the maximum.
    void record_compressions(const series::Contact& f) {
        const ContactPair<Law>& q = network.pairs[f.pair];
        if (!f.closed || !q.may_be_deepest) return;
        const series::Terms& shape = f.second < 0 ? f.depth : f.bodies.distance;
        const double sign = f.second < 0 ? 1.0 : -1.0, whole = f.second < 0 ? 0.0 : f.contact_distance;
        const double radius = network.smaller_radius(q);
        struct Depth {
            double value, rate, bend;
        };
        const auto depth = [&](double t) {
            double value = 0.0, rate = 0.0, bend = 0.0;
            for (int k = series::order; k >= 0; --k) {
                bend = bend * t + 2.0 * rate;
                rate = rate * t + value;
                value = value * t + shape[static_cast<std::size_t>(k)];
            }
            return Depth{whole + sign * value, sign * rate, sign * bend};
        };
        const Depth first = depth(0.0), last = depth(end);
        ledger.add_compression(math::max(first.value, last.value) / radius);
        if (!(first.rate > 0.0 && last.rate < 0.0)) return;
        double t = end * (first.rate / (first.rate - last.rate));
        for (int i = 0; i < 8; ++i) {
            const Depth here = depth(t);
            ledger.add_compression(here.value / radius);
            const double next = math::clamp(t - here.rate / here.bend, 0.0, end);
            if (!(math::abs(next - t) > 1e-7 * end)) break;
            t = next;
        }
    }

    // Opens slack pairs that are apart after the step, even if one was predicted to engage at that instant.
    void open_pairs() {
        for (const series::Contact& f : expansion.contacts) {
            ContactPair<Law>& q = network.pairs[f.pair];
            if (q.state != ContactState::slack || state.at(network).geometry(q).depth > 0.0) continue;
            q.state = ContactState::open;
            q.fresh = false;
            if (event.pair == f.pair) event = {};
        }
    }
};

}  // namespace hardlimit::boxes
