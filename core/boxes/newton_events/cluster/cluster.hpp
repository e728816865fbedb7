// Newton's equations for a few spheres or disks whose contacts overlap in time, under any contact law:
//   m_i dv_i/dt = Σ_j F_ij n_ij + m_i g,   F = force(s, dξ/dt) while the contact is closed, otherwise 0,
//   ξ = s^p = R_i + R_j − |r_ij|  (at a wall: R_i − distance of the centre),   dξ/dt = −n·(v_j − v_i).
// The method is that of columns (column/general/motions.hpp says why): order 8, every begin and end of a contact
// located. A force like ξ^{3/2} has a singular derivative at touch. While such a contact is closed its s is integrated
// beside the positions, and time runs as dt = γ dτ,
//   ds/dτ = (dξ/dt) γ/(p s^{p−1}),   1/γ² = 1 + Σ (s/ℓ)^{2−2p}   over these contacts,
// so that everything is smooth in τ. For p = 1 there is no s, and γ = 1.
//
// Events of a pair, each with the function that falls to zero there (d = depth of the law's slack at this rate):
//   open → closed      −ξ                           slack → open      ξ
//   closed → slack     s − max(d, 0)^{1/p}          slack → closed    −(ξ − d)      (a new contact)
// A closed pair that reaches the largest compression of its law (deepest_compression) ends the run of the cluster.
// Under a linear law a step is a series instead (cluster/linear.hpp), and these events are zeros of polynomials.
//
// A slack pair overlaps without force. A pair that has just been put on a surface is `fresh`: what vanishes there
// counts again once it has become positive; a value below zero while it rises is rounding.
#pragma once
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "../../../base/dormand_prince.hpp"
#include "../../../base/event_function.hpp"
#include "../../../base/stop.hpp"
#include "../../../column/general/events.hpp"
#include "../../../contact/law.hpp"
#include "../../binary_contact/planar_contact.hpp"
#include "../../common/triangle.hpp"
#include "../../kernels/cluster_series.hpp"

namespace hardlimit::boxes {

struct Member {
    double mass, radius;  // [kg], [m]
    Vector3 position;     // from an origin near the cluster [m]
    Vector3 velocity;     // [m/s]
};

enum class Touch : unsigned char { open, slack, closed };

// Two members, or a member and a wall.
template <class Law>
struct Touching {
    int first, second;  // second < 0: a wall
    Vector3 image;      // added to x_second − x_first: the periodic image that is near
    int axis;           // of the wall's normal
    double side;        // of a wall: +1 at the low end of the axis, −1 at the high one
    double wall;        // its coordinate along the axis, from the cluster's origin
    double reach;       // R_first + R_second; at a wall R_first [m]
    double mass;        // effective mass [kg]
    Law law;
    Touch touch = Touch::open;
    bool fresh = false;       // has just been put on a surface
    bool rooted = false;      // s is integrated
    bool overlapped = false;  // shared a body with another contact while it lasted
    bool scaled = false;      // what follows is known
    bool may_be_too_deep = false, may_be_deepest = false;  // the cluster has the energy for it
    double s = 0.0;                                        // where rooted
    double s_unit = 0.0, depth_unit = 0.0;
    double begin = 0.0, impact_speed = 0.0;  // of the contact that is closed
};

// The user's number of its wall: −1 − 2·axis at 0, −2 − 2·axis at the edge.
template <class Law>
int wall_number(const Touching<Law>& q) {
    return (q.side > 0.0 ? -1 : -2) - 2 * q.axis;
}

// One contact that has ended.
struct EndedContact {
    int pair;
    double begin, end;
    double impact_speed, separation_speed;
    bool overlapped;
};

// The state of the members at instants between which little happens.
struct Trace {
    std::vector<double> time;
    std::vector<double> state;  // for each instant positions, then velocities
    std::vector<double>
        bulge;  // [members] by which a path can have left its line since the last one, where known

    void clear() {
        time.clear();
        state.clear();
        bulge.clear();
    }
};

inline constexpr long no_limit = std::numeric_limits<long>::max();

template <class Law>
class Cluster {
    static_assert(FrictionlessLaw<Law>);

public:
    static constexpr int p = Law::onset_power;

    std::vector<Member> members;
    std::vector<Touching<Law>> pairs;
    Vector3 gravity{};
    double largest_place = 0.0;  // before places were counted from an origin near all members [m]
    const hardlimit_abi::SeriesKernels* kernels = nullptr;  // under a linear law
    double base = 0.0;                                      // the instant from which `time` counts [s]
    double time = 0.0;                                      // [s]
    double dissipated = 0.0;                                // and what slack pairs still hold [J]
    double virial = 0.0;                                    // ∫ Σ r·F dt over pairs of bodies [J s]
    double tolerance = 1e-11;  // of a step, relative to the units of length, speed and time
    bool record = false;
    std::vector<EndedContact> ended;
    Trace trace;
    bool unresolved = false;
    int too_deep = -1;                 // the pair that ended the run
    double largest_compression = 0.0;  // of all contacts, and of those before, over the smaller radius
    long begun = 0, begun_pairs = 0;   // contacts since the start of this object; those between two bodies

    // As a new one, but for its storage.
    void clear() {
        members.clear();
        pairs.clear();
        ended.clear();
        trace.clear();
        base = time = dissipated = virial = largest_compression = 0.0;
        too_deep = -1;
        record = unresolved = known_ = false;
        begun = begun_pairs = steps_ = 0;
        h_ = 0.0;
    }

    // Goes on to `until`, or to the instant at which the last pair has opened if that comes first; or after so many
    // steps to where it is then.
    void run(double until, Stop& stop, long most_steps = no_limit) { run(until, stop, most_steps, false); }

    // Goes on to `until` though all pairs may have opened before. Where one opens at the instant at which another one
    // touches, rounding decides which of them comes first, and it may decide otherwise where steps end elsewhere.
    void run_through(double until) {
        Stop never;
        run(until, never, no_limit, true);
    }

    // So far.
    long steps() const { return steps_; }

    // Approach of a pair now [m/s].
    double rate(const Touching<Law>& q) const { return geometry_of_members(q).rate; }

    // Distance of a pair's surfaces now [m].
    double gap(const Touching<Law>& q) const { return -geometry_of_members(q).depth; }

    // The largest speed at which a member can move against the others, and against walls if one may be touched [m/s].
    double speed() const { return unit_of_speed(); }

    bool near_a_wall() const {
        return std::any_of(pairs.begin(), pairs.end(), [](const auto& q) { return q.second < 0; });
    }

    // Of all members together; none near a wall, where all of a velocity counts [m/s].
    Vector3 drift() const {
        Vector3 mean{};
        if (near_a_wall()) return mean;
        double mass = 0.0;
        for (const Member& m : members) {
            mass += m.mass;
            for (std::size_t a = 0; a < 3; ++a) mean[a] += m.mass * m.velocity[a];
        }
        for (double& x : mean) x /= mass;
        return mean;
    }

    // Elastic energy of the pairs that push each other, or of those that overlap without force [J].
    double stored(Touch state) const {
        double sum = 0.0;
        for (const Touching<Law>& pair : pairs)
            if (pair.touch == state) sum += pair.law.energy(math::max(depth_root(pair), 0.0));
        return sum;
    }

private:
    void run(double until, Stop& stop, long most_steps, bool through) {
        gather();
        const double from = time;
        const long before = steps_;
        while (time < until && !unresolved && too_deep < 0 && !stop()) {
            if (!through && all(Touch::open)) break;
            if (!(speed_unit_ > at_rest))
                stay(until);
            else if (!any(Touch::closed))
                fly(until);
            else if constexpr (LinearLaw<Law>)
                follow(until);
            else
                integrate(until);
            if (++steps_ > 10'000'000) unresolved = true;
            if (steps_ - before >= most_steps && time > from) break;
        }
        scatter();
    }

    // Below that a square is no number any more, and nobody gets anywhere [m/s].
    static constexpr double at_rest = 1e-150;
    // Part of the sum of the radii from which on a compression is known by the positions.
    static constexpr double resolved_depth = 1e-12;

    enum class Event : unsigned char { none, begins, ends, opens, engages, deepens };
    struct Geometry {
        double depth, rate, distance;
        Vector3 normal;  // from the first body to the second
    };

    // What a copy does not need: everyone keeps his own storage.
    template <class T>
    struct Scratch : std::vector<T> {
        Scratch() = default;
        Scratch(const Scratch&) : std::vector<T>() {}
        Scratch& operator=(const Scratch&) { return *this; }
        Scratch(Scratch&&) noexcept : std::vector<T>() {}
        Scratch& operator=(Scratch&&) noexcept { return *this; }
        ~Scratch() = default;
    };

    Scratch<double> y_, k_, end_, k_end_, trial_, k_trial_, tolerance_;
    mutable Scratch<double> stages_, factor_;
    Scratch<series::Path> paths_;  // [members]
    Scratch<double> travel_;       // [members] how far one can get within a step
    Scratch<int> order_;           // [members] those in contact, then the others
    Scratch<char> ordered_;        // [members]
    int pushed_ = 0;               // how many are in contact
    Scratch<series::Followed> followed_;
    Scratch<int> rooted_;  // pairs whose s is a component, in the order of the state
    Scratch<int> slot_;    // [pairs] the component of s
    bool known_ = false;   // whether k_ is the derivative of y_
    double h_ = 0.0, speed_unit_ = 0.0, lightest_ = 0.0;
    double step_ = 0.0;  // of the series, in its unit, at most 1
    long steps_ = 0;

    int count() const { return static_cast<int>(members.size()); }
    int clock() const { return 6 * count(); }
    int loss() const { return 6 * count() + 1; }
    int first_root() const { return 6 * count() + 3; }
    int work() const { return 6 * count() + 2; }
    int dimension() const { return first_root() + static_cast<int>(rooted_.size()); }

    bool all(Touch state) const {
        return std::all_of(pairs.begin(), pairs.end(), [&](const auto& q) { return q.touch == state; });
    }
    bool any(Touch state) const {
        return std::any_of(pairs.begin(), pairs.end(), [&](const auto& q) { return q.touch == state; });
    }

    static double power(double x, int n) {
        double product = 1.0;
        for (int i = 0; i < n; ++i) product *= x;
        return product;
    }

    // ---- in and out ---------------------------------------------------------------------------------------

    void gather() {
        slot_.assign(pairs.size(), -1);
        rooted_.clear();
        for (std::size_t q = 0; q < pairs.size(); ++q) {
            if (!pairs[q].rooted) continue;
            slot_[q] = first_root() + static_cast<int>(rooted_.size());
            rooted_.push_back(static_cast<int>(q));
        }
        y_.assign(static_cast<std::size_t>(dimension()), 0.0);
        for (int i = 0; i < count(); ++i)
            for (int a = 0; a < 3; ++a) {
                y_[3 * i + a] = members[i].position[a];
                y_[3 * (count() + i) + a] = members[i].velocity[a];
            }
        y_[clock()] = time;
        y_[loss()] = dissipated;
        y_[work()] = virial;
        for (const int q : rooted_) y_[slot_[q]] = pairs[q].s;
        if constexpr (!LinearLaw<Law>) resize();
        choose_units();
        known_ = false;
        trace.clear();
        keep();
    }

    void resize() {
        const auto n = static_cast<std::size_t>(dimension());
        for (auto* v : {&k_, &end_, &k_end_, &trial_, &k_trial_, &tolerance_}) v->resize(n);
        stages_.resize(n * DormandPrince::stages);
        factor_.resize(pairs.size());
    }

    void scatter() {
        for (int i = 0; i < count(); ++i)
            for (int a = 0; a < 3; ++a) {
                members[i].position[a] = y_[3 * i + a];
                members[i].velocity[a] = y_[3 * (count() + i) + a];
            }
        dissipated = y_[loss()];
        virial = y_[work()];
        for (const int q : rooted_) pairs[q].s = y_[slot_[q]];
    }

    void keep() {
        if (!record) return;
        trace.time.push_back(y_[clock()]);
        trace.state.insert(trace.state.end(), y_.begin(), y_.begin() + 6 * count());
        if constexpr (LinearLaw<Law>) trace.bulge.resize(trace.time.size() * members.size());
    }

    // The speed of the lightest member with all energy: that of the velocities but for their drift, and what is stored.
    void choose_units() {
        lightest_ = lightest();
        speed_unit_ = unit_of_speed();
    }

    double lightest() const {
        double least = math::infinity;
        for (const Member& m : members) least = math::min(least, m.mass);
        return least;
    }

    double unit_of_speed() const {
        const Vector3 mean = drift();
        double energy = 0.0;
        for (const Member& m : members)
            for (int a = 0; a < 3; ++a)
                energy += 0.5 * m.mass * (m.velocity[a] - mean[a]) * (m.velocity[a] - mean[a]);
        for (const Touching<Law>& q : pairs)
            if (q.touch == Touch::closed) energy += q.law.energy(depth_root(q));
        // What weight adds on a millionth of a radius: bodies may lie at rest.
        double smallest = math::infinity;
        for (const Member& m : members) smallest = math::min(smallest, m.radius);
        const double fall = 1e-6 * smallest * math::sqrt(dot(gravity, gravity));
        return math::max(math::sqrt(2.0 * energy / lightest() + fall), slowest_approach);
    }

    void scale(Touching<Law>& q) const {
        if (q.scaled) return;
        const double mass = math::min(q.mass, lightest_);  // there is no more energy
        if constexpr (LinearLaw<Law>) {
            q.s_unit = speed_unit_ * math::sqrt(mass / q.law.elastic_force(1.0));
        } else {
            const double energy = 0.5 * mass * speed_unit_ * speed_unit_;
            q.s_unit = column::newton::solve_power([&](double x) { return q.law.energy(x); }, energy);
        }
        q.depth_unit = power(q.s_unit, p);
        const auto may_reach = [&](double part) {
            return q.law.energy(onset_root<p>(part * smaller_radius(q))) <= most_energy();
        };
        q.may_be_too_deep = may_reach(deepest_compression);
        q.may_be_deepest = may_reach(largest_compression);
        q.scaled = true;
    }

    double smaller_radius(const Touching<Law>& q) const {
        const double first = members[static_cast<std::size_t>(q.first)].radius;
        return q.second < 0 ? first : math::min(first, members[static_cast<std::size_t>(q.second)].radius);
    }

    // That one contact can store: all of it, and what the members' weight does over a radius each [J].
    double most_energy() const {
        const double pull = math::sqrt(dot(gravity, gravity));
        double sum = energy_unit();
        for (const Member& m : members) sum += m.mass * pull * m.radius;
        return sum;
    }

    void note_depth(const Touching<Law>& q, double depth) {
        largest_compression = math::max(largest_compression, depth / smaller_radius(q));
    }

    double time_unit() const {
        double least = math::infinity;
        for (const Touching<Law>& q : pairs)
            if (q.touch == Touch::closed) least = math::min(least, q.depth_unit);
        return least / speed_unit_;
    }

    // ---- geometry -----------------------------------------------------------------------------------------

    Geometry geometry(const Touching<Law>& q, const double* y) const {
        const double *xa = y + 3 * q.first, *va = y + 3 * (count() + q.first);
        if (q.second < 0) return geometry(q, xa, va, nullptr, nullptr);
        return geometry(q, xa, va, y + 3 * q.second, y + 3 * (count() + q.second));
    }
    Geometry geometry_of_members(const Touching<Law>& q) const {
        const Member& a = members[static_cast<std::size_t>(q.first)];
        const Member& b = members[static_cast<std::size_t>(q.second < 0 ? q.first : q.second)];
        return geometry(q, a.position.data(), a.velocity.data(), b.position.data(), b.velocity.data());
    }
    static Geometry geometry(const Touching<Law>& q, const double* xa, const double* va, const double* xb,
                             const double* vb) {
        Geometry g{};
        if (q.second < 0) {
            const double away = q.side * (xa[q.axis] - q.wall);
            g.normal[static_cast<std::size_t>(q.axis)] = -q.side;
            g.depth = q.reach - away;
            g.rate = -q.side * va[q.axis];
            g.distance = math::infinity;
            return g;
        }
        Vector3 v;
        for (std::size_t a = 0; a < 3; ++a) {
            g.normal[a] = (xb[a] - xa[a]) + q.image[a];
            v[a] = vb[a] - va[a];
        }
        g.distance = math::sqrt(dot(g.normal, g.normal));
        const double inverse = 1.0 / g.distance;
        for (double& x : g.normal) x *= inverse;
        g.depth = q.reach - g.distance;
        g.rate = -dot(g.normal, v);
        return g;
    }

    double depth_root(const Touching<Law>& q) const {
        if (q.rooted) return q.s;
        Vector3 r{};
        const Vector3& a = members[static_cast<std::size_t>(q.first)].position;
        if (q.second < 0)
            return onset_root<p>(q.reach - q.side * (a[static_cast<std::size_t>(q.axis)] - q.wall));
        const Vector3& b = members[static_cast<std::size_t>(q.second)].position;
        for (std::size_t i = 0; i < 3; ++i) r[i] = (b[i] - a[i]) + q.image[i];
        return onset_root<p>(q.reach - math::sqrt(dot(r, r)));
    }

    double root(int q, const Geometry& g, const double* y) const {
        return pairs[static_cast<std::size_t>(q)].rooted ? y[slot_[static_cast<std::size_t>(q)]]
                                                         : onset_root<p>(g.depth);
    }

    // ---- the equations of motion --------------------------------------------------------------------------

    // Returns γ, and leaves γ (ℓ/s)^{p−1} of each rooted contact in factor_, which is at most 1.
    double clock_rate(const double* y) const {
        if constexpr (p == 1) return 1.0;
        if (rooted_.empty()) return 1.0;
        int least = -1;
        for (const int q : rooted_) {
            factor_[q] = power(y[slot_[q]] / pairs[q].s_unit, p - 1);
            if (least < 0 || math::abs(factor_[q]) < math::abs(factor_[least])) least = q;
        }
        const double smallest = factor_[least];
        double square = smallest * smallest;
        for (const int q : rooted_) {
            factor_[q] = factor_[q] == smallest ? 1.0 : smallest / factor_[q];  // several may be zero
            square += factor_[q] * factor_[q];
        }
        const double norm = math::sqrt(square);
        for (const int q : rooted_) factor_[q] /= norm;
        return smallest / norm;
    }

    struct Equations {
        const Cluster* cluster;
        void operator()(const double* y, double* dy) const { cluster->derivative(y, dy); }
    };

    void derivative(const double* y, double* dy) const {
        const int n = count();
        const double gamma = clock_rate(y);
        for (int i = 0; i < 3 * n; ++i) dy[i] = gamma * y[3 * n + i];
        for (int i = 3 * n; i < 6 * n; i += 3)
            for (std::size_t a = 0; a < 3; ++a) dy[static_cast<std::size_t>(i) + a] = gravity[a];
        double loss_rate = 0.0, pressing = 0.0;
        for (std::size_t q = 0; q < pairs.size(); ++q) {
            const Touching<Law>& pair = pairs[q];
            if (pair.touch != Touch::closed) continue;
            const Geometry g = geometry(pair, y);
            const double s = root(static_cast<int>(q), g, y);
            const double force = pair.law.force(s, g.rate);
            loss_rate += (force - pair.law.elastic_force(s)) * g.rate;
            if (pair.second >= 0) pressing += force * g.distance;
            for (int a = 0; a < 3; ++a) {
                const double along = force * g.normal[static_cast<std::size_t>(a)];
                dy[3 * (n + pair.first) + a] -= along / members[pair.first].mass;
                if (pair.second >= 0) dy[3 * (n + pair.second) + a] += along / members[pair.second].mass;
            }
            if (pair.rooted) dy[slot_[q]] = g.rate / p * factor_[q] / power(pair.s_unit, p - 1);
        }
        if constexpr (p > 1)
            for (int i = 3 * n; i < 6 * n; ++i) dy[i] *= gamma;
        dy[clock()] = gamma;
        dy[loss()] = gamma * loss_rate;
        dy[work()] = gamma * pressing;
    }

    void advance(double length, double* out) const {
        std::copy(k_.begin(), k_.end(), stages_.begin());
        DormandPrince::step(Equations{this}, y_.data(), length, dimension(), stages_.data(), out);
    }

    // ---- one step -----------------------------------------------------------------------------------------

    // s where the contact is compressed or being compressed in earnest, the positions elsewhere; but s stays where the
    // compression is lost in the rounding of the positions. One that has hardly begun and hardly moves would stop the
    // clock for all.
    void choose_coordinates() {
        if constexpr (p == 1) return;
        bool changed = false, at_zero = false;
        const double unit = time_unit();
        std::vector<int> chosen;
        for (std::size_t q = 0; q < pairs.size(); ++q) {
            Touching<Law>& pair = pairs[q];
            bool use = false;
            if (pair.touch == Touch::closed) {
                const Geometry g = geometry(pair, y_.data());
                const double sigma = root(static_cast<int>(q), g, y_.data()) / pair.s_unit;
                const bool earnest = sigma > 0.1 || math::abs(g.rate) > sigma * speed_unit_;
                const bool lost = pair.rooted && g.depth < resolved_depth * pair.reach;
                const bool still = sigma < 0.01 && !(math::abs(g.rate) * unit > rounding(pair));
                use = (earnest || lost) && !still && !(sigma <= 0.0 && at_zero);
                at_zero = at_zero || (use && sigma <= 0.0);
            }
            if (use) chosen.push_back(static_cast<int>(q));
            changed = changed || use != pair.rooted;
        }
        if (changed) rearrange(chosen);
    }

    void rearrange(const std::vector<int>& chosen) {
        Scratch<double> y;
        y.assign(y_.begin(), y_.begin() + first_root());
        for (const int q : chosen) y.push_back(root(q, geometry(pairs[q], y_.data()), y_.data()));
        for (Touching<Law>& q : pairs) q.rooted = false;
        rooted_.assign(chosen.begin(), chosen.end());
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            pairs[chosen[i]].rooted = true;
            slot_[chosen[i]] = first_root() + static_cast<int>(i);
        }
        y_.swap(y);
        known_ = false;
        resize();
        h_ = math::min(h_, 0.25 * time_unit());
    }

    void integrate(double until) {
        for (Touching<Law>& q : pairs)
            if (q.touch == Touch::closed) scale(q);
        choose_coordinates();
        if (!(h_ > 0.0)) h_ = 0.25 * time_unit();
        if (!known_) derivative(y_.data(), k_.data());
        known_ = true;
        if (at_surface([this](int q, Event kind) { return surface(q, kind, y_.data(), k_.data()).value; }))
            return;
        const int n = dimension();
        double length = h_;
        bool last = false;
        if constexpr (p == 1) {
            last = length >= until - y_[clock()];
            if (last) length = until - y_[clock()];
        }
        advance(length, end_.data());
        set_tolerance(length);
        const double error = DormandPrince::error(stages_.data(), length, n, tolerance_.data());
        const double growth = DormandPrince::growth(error);
        if (!(error <= 1.0)) {
            h_ = length * growth;
            if (h_ < 1e-20 * time_unit()) unresolved = true;
            return;
        }
        if (!last || growth < 1.0) h_ = length * growth;
        derivative(end_.data(), k_end_.data());
        if (end_[clock()] > until) {
            length = reach(until, length);
            last = true;
        }
        Event what = Event::none;
        int which = 0;
        for (std::size_t q = 0; q < pairs.size(); ++q)
            for (const Event kind : events_of(pairs[q]))
                if (kind != Event::none && crosses(static_cast<int>(q), kind, length)) {
                    what = kind;
                    which = static_cast<int>(q);
                    last = false;
                }
        if (ends_within_rounding()) return;
        if (what != Event::none && end_[clock()] > until) {  // beyond touch time had run back from there
            length = reach(until, length);
            last = true;
            what = Event::none;
        }
        for (std::size_t q = 0; q < pairs.size(); ++q)
            if (pairs[q].fresh && (what == Event::none || which != static_cast<int>(q)))
                pairs[q].fresh = still_fresh(static_cast<int>(q));
        note_depths(length);
        y_.swap(end_);
        k_.swap(k_end_);
        if (last) y_[clock()] = until;
        time = y_[clock()];
        keep();
        if (what != Event::none) apply(what, which);
    }

    // The greatest compressions in the step from y_ to end_. Where the rate falls through zero, one more step leads
    // near the zero, and a parabola to the greatest compression.
    void note_depths(double length) {
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const Touching<Law>& q = pairs[i];
            if (q.touch != Touch::closed || !q.may_be_deepest) continue;
            const Geometry a = geometry(q, y_.data()), b = geometry(q, end_.data());
            note_depth(q, math::max(a.depth, b.depth));
            if (!(a.rate > 0.0 && b.rate < 0.0)) continue;
            probe(length * (a.rate / (a.rate - b.rate)));
            const Geometry near = geometry(q, trial_.data());
            const double slope = acceleration(q, near, trial_.data(), k_trial_.data());
            const double beyond = k_trial_[clock()] * near.rate * near.rate / (-2.0 * slope);
            note_depth(q, near.depth + (slope < 0.0 ? beyond : 0.0));
        }
    }

    // A contact that has begun within rounding of touch and parts is over: with s < 0, γ would be too, and time would
    // run backwards.
    bool ends_within_rounding() {
        if (!(end_[clock()] < y_[clock()])) return false;
        for (const int q : rooted_)
            if (end_[slot_[q]] < 0.0) {
                apply(Event::ends, q);
                return true;
            }
        return false;
    }

    // Shortens the step so that it ends at the time `until`; the state there is left in end_.
    double reach(double until, double length) {
        double low = 0.0, high = length, at = length * (until - y_[clock()]) / (end_[clock()] - y_[clock()]);
        for (int i = 0; i < 80; ++i) {
            probe(at);
            const double excess = trial_[clock()] - until;
            (excess > 0.0 ? high : low) = at;
            const double next = at - excess / k_trial_[clock()], previous = at;
            at = next > low && next < high ? next : 0.5 * (low + high);
            if (math::abs(at - previous) <= 4.0 * math::epsilon * length) break;
        }
        probe(at);
        end_.swap(trial_);
        k_end_.swap(k_trial_);
        return at;
    }

    void set_tolerance(double length) {
        const int n = count();
        double depth = math::infinity, force = 0.0;
        for (std::size_t q = 0; q < pairs.size(); ++q) {
            if (pairs[q].touch != Touch::closed) continue;
            depth = math::min(depth, pairs[q].depth_unit);
            const Geometry g = geometry(pairs[q], y_.data());
            force = math::max(force,
                              math::abs(pairs[q].law.force(root(static_cast<int>(q), g, y_.data()), g.rate)));
        }
        for (int i = 0; i < n; ++i) {
            // Rounding of the forces is no error of the step, and a shorter step would not lessen its rate.
            const double rounding = 0.25 * math::epsilon * length * force / members[i].mass;
            const double fastest = speed_unit_ * math::sqrt(lightest_ / members[i].mass);  // with all energy
            for (int a = 0; a < 3; ++a) {
                tolerance_[3 * i + a] =
                    math::max(tolerance * depth, 4.0 * math::epsilon * math::abs(y_[3 * i + a]));
                tolerance_[3 * (n + i) + a] = math::max(tolerance * fastest, rounding);
            }
        }
        tolerance_[clock()] = tolerance * time_unit();
        tolerance_[loss()] = tolerance * math::max(energy_unit(), math::abs(y_[loss()] - dissipated));
        tolerance_[work()] = math::infinity;
        for (const int q : rooted_)
            tolerance_[slot_[q]] = tolerance * (math::abs(y_[slot_[q]]) + pairs[q].s_unit);
    }

    double energy_unit() const { return 0.5 * lightest_ * speed_unit_ * speed_unit_; }

    // cluster/linear.hpp
    struct Found {  // what comes first in a step
        double at;  // in units of the series
        Event what = Event::none;
        int which = 0;
    };
    void follow(double until);
    double series_unit() const;
    double height(const Touching<Law>& q, Event kind) const;
    bool lies_on_surface(const Touching<Law>& q) const;
    bool on_surface();
    void expand(double unit);
    void take_up(int index, double unit);
    double longest_step() const;
    void find_end(const series::Followed& f, Found& found) const;
    void find_depth(const series::Followed& f, Found& found) const;
    void note_depths(const series::Followed& f, double at);
    void open_pairs(Found& found);
    void put_in_order();
    void find_begins(Found& found);
    void find_begin(int index, Found& found);
    void consider(int index, Event kind, const series::Terms& f, double unit, Found& found) const;
    void move(double at, double unit);
    std::array<double, 4> pull() const { return {gravity[0], gravity[1], gravity[2], 0.0}; }

    void stay(double until) {
        time = y_[clock()] = until;
        keep();
    }

    // No pair pushes: the bodies fly to the next event of a pair, in closed form.
    void fly(double until) {
        double least = until - y_[clock()];
        Event what = Event::none;
        int which = 0;
        const auto consider = [&](double t, Event kind, int q) {
            if (t < least) {
                least = math::max(t, 0.0);
                what = kind;
                which = q;
            }
        };
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const Touching<Law>& q = pairs[i];
            const int index = static_cast<int>(i);
            if (q.touch == Touch::open) {
                consider(time_to_touch(q), Event::begins, index);
            } else {
                consider(time_to_open(q), Event::opens, index);
                consider(time_to_engage(q), Event::engages, index);
            }
        }
        for (int i = 0; i < count(); ++i)
            for (int a = 0; a < 3; ++a) {
                double &x = y_[3 * i + a], &v = y_[3 * (count() + i) + a];
                const double g = gravity[static_cast<std::size_t>(a)];
                x += least * (v + 0.5 * g * least);
                v += g * least;
            }
        y_[clock()] = what == Event::none ? until : y_[clock()] + least;
        time = y_[clock()];
        known_ = false;
        if (least > 0.0)
            for (Touching<Law>& q : pairs) q.fresh = false;
        keep();
        if (what != Event::none) apply(what, which);
    }

    double fall(const Touching<Law>& q) const {  // acceleration towards a wall
        return q.second < 0 ? -q.side * gravity[static_cast<std::size_t>(q.axis)] : 0.0;
    }

    // First t at which |r + v t| = reach from outside; at a wall the parabola meets it.
    double time_to_touch(const Touching<Law>& q) const {
        const Geometry g = geometry(q, y_.data());
        if (q.second < 0) {
            const double gap = q.fresh ? 0.0 : math::max(-g.depth, 0.0), towards = fall(q);
            if (gap == 0.0 && g.rate > 0.0) return 0.0;
            if (gap == 0.0) return towards > 0.0 ? -2.0 * g.rate / towards : math::infinity;
            const double square = g.rate * g.rate + 2.0 * towards * gap;
            if (square < 0.0 || (g.rate <= 0.0 && towards <= 0.0)) return math::infinity;
            if (g.rate > 0.0) return 2.0 * gap / (g.rate + math::sqrt(square));
            return (math::sqrt(square) - g.rate) / towards;
        }
        if (!(g.rate > 0.0)) return math::infinity;
        const double speed2 = relative_speed_squared(q);
        const double b = g.rate * g.distance, c = -g.depth * (g.distance + q.reach);  // c = r² − reach²
        if (c <= 0.0) return 0.0;
        const double square = b * b - speed2 * c;
        return square < 0.0 ? math::infinity : c / (b + math::sqrt(square));
    }

    double time_to_open(const Touching<Law>& q) const {
        const Geometry g = geometry(q, y_.data());
        if (q.second < 0) {
            const double towards = fall(q), square = g.rate * g.rate - 2.0 * towards * g.depth;
            if (g.depth <= 0.0) return 0.0;
            if (square < 0.0 || (g.rate >= 0.0 && towards >= 0.0)) return math::infinity;
            if (g.rate <= 0.0) return 2.0 * g.depth / (math::sqrt(square) - g.rate);
            return -(g.rate + math::sqrt(square)) / towards;
        }
        const double speed2 = relative_speed_squared(q);
        const double b = -g.rate * g.distance, c = g.depth * (g.distance + q.reach);  // reach² − r²
        if (c <= 0.0) return 0.0;
        if (speed2 == 0.0) return math::infinity;
        return b > 0.0 ? c / (b + math::sqrt(b * b + speed2 * c))
                       : (math::sqrt(b * b + speed2 * c) - b) / speed2;
    }

    // Two bodies that separate on straight lines never push again: ξ falls and the slack grows.
    double time_to_engage(const Touching<Law>& q) const {
        const Geometry g = geometry(q, y_.data());
        if (q.second >= 0) return g.rate > 0.0 ? 0.0 : math::infinity;
        return column::newton::time_to_engage(q.law, g.depth, g.rate, fall(q), q.fresh);
    }

    double relative_speed_squared(const Touching<Law>& q) const {
        double sum = 0.0;
        for (int a = 0; a < 3; ++a) {
            const double v = y_[3 * (count() + q.second) + a] - y_[3 * (count() + q.first) + a];
            sum += v * v;
        }
        return sum;
    }

    // ---- events -------------------------------------------------------------------------------------------

    static std::array<Event, 2> events_of(const Touching<Law>& q) {
        if (q.touch == Touch::open) return {Event::begins, Event::none};
        if (q.touch == Touch::slack) return {Event::opens, Event::engages};
        return {Event::ends, q.may_be_too_deep ? Event::deepens : Event::none};
    }

    // What is left of the largest compression of the law [m].
    double depth_left(const Touching<Law>& q, const Geometry& g) const {
        return deepest_compression * smaller_radius(q) - g.depth;
    }

    Surface surface(int index, Event kind, const double* y, const double* dy) const {
        const Touching<Law>& q = pairs[static_cast<std::size_t>(index)];
        const Geometry g = geometry(q, y);
        const double gamma = dy[clock()], depth_slope = gamma * g.rate;
        const auto simple = [](double f, double df) { return Surface{f, df, f, df}; };
        if (kind == Event::begins) return simple(-g.depth, -depth_slope);
        if (kind == Event::opens) return simple(g.depth, depth_slope);
        if (kind == Event::deepens) return simple(depth_left(q, g), -depth_slope);
        const Slack slack = q.law.slack(g.rate);
        const double rate_slope = acceleration(q, g, y, dy);
        const double excess = g.depth - slack.depth, excess_slope = depth_slope - slack.slope * rate_slope;
        if (kind == Event::engages) return simple(-excess, -excess_slope);
        if (!q.rooted) return simple(excess, excess_slope);
        const double at = y[slot_[static_cast<std::size_t>(index)]],
                     change = dy[slot_[static_cast<std::size_t>(index)]];
        if (!(slack.depth > 0.0)) return {at, change, excess, excess_slope};
        const double least = onset_root<p>(slack.depth), share = slack.slope * g.rate / slack.depth;
        return {at - least, change - least * rate_slope * share / (p * g.rate), excess, excess_slope};
    }

    // d(rate)/dτ
    double acceleration(const Touching<Law>& q, const Geometry& g, const double* y, const double* dy) const {
        const double* a = dy + 3 * (count() + q.first);
        if (q.second < 0) return -q.side * a[q.axis];
        const double* b = dy + 3 * (count() + q.second);
        double along = 0.0;
        for (std::size_t i = 0; i < 3; ++i) along += (b[i] - a[i]) * g.normal[i];
        double speed2 = 0.0;
        for (int i = 0; i < 3; ++i) {
            const double v = y[3 * (count() + q.second) + i] - y[3 * (count() + q.first) + i];
            speed2 += v * v;
        }
        return -along - dy[clock()] * (speed2 - g.rate * g.rate) / g.distance;
    }

    bool still_fresh(int q) const {
        for (const Event kind : events_of(pairs[static_cast<std::size_t>(q)]))
            if (kind != Event::none && !(surface(q, kind, end_.data(), k_end_.data()).value > 0.0))
                return true;
        return false;
    }

    void probe(double at) {
        advance(at, trial_.data());
        derivative(trial_.data(), k_trial_.data());
    }

    // Looks for a zero of one surface in (0, length]; if there is one, `length` and end_ move to it.
    bool crosses(int q, Event kind, double& length) {
        const bool fresh = pairs[static_cast<std::size_t>(q)].fresh;
        const Surface a = surface(q, kind, y_.data(), k_.data());
        const Surface b = surface(q, kind, end_.data(), k_end_.data());
        double high = length;
        if (b.value > 0.0 || (fresh && b.value == 0.0)) {
            if (!(a.smooth_slope < 0.0 && b.smooth_slope > 0.0)) return false;
            const auto at = [&](double x) {
                probe(x);
                return surface(q, kind, trial_.data(), k_trial_.data());
            };
            if (!dips(a, b, high, at)) return false;
        } else if (fresh && a.smooth_slope >= 0.0 && b.smooth_slope >= 0.0) {
            return false;  // rising from the surface: rounding
        } else if (fresh && kind == Event::begins &&
                   b.value > -rounding(pairs[static_cast<std::size_t>(q)])) {
            return false;
        }
        locate(q, kind, a, b, length, high);
        length = high;
        end_.swap(trial_);
        k_end_.swap(k_trial_);
        return true;
    }

    // First zero in (0, high], the surface being below zero at `high`; leaves the state there in trial_. Starts from
    // the zero of the cubic through the two ends of the step. What is left of the way is soon so short that the
    // midpoint rule, whose error is of the third order in it, goes it in two evaluations instead of twelve.
    void locate(int q, Event kind, const Surface& a, const Surface& b, double length, double& high) {
        double low = 0.0, up = high, at = first_guess(q, a, b, length, high);
        probe(at);
        for (int i = 0; i < 100; ++i) {
            const Surface f = surface(q, kind, trial_.data(), k_trial_.data());
            (f.value > 0.0 ? low : up) = at;
            const double newton = at - f.value / f.slope;
            const double next = newton >= low && newton <= up && f.slope < 0.0 ? newton : 0.5 * (low + up);
            const bool close =
                math::abs(f.smooth) <= rounding(pairs[static_cast<std::size_t>(q)]) || next == at;
            if (close || math::abs(next - at) <= 1e-14 * length) break;
            if (math::abs(next - at) <= 1e-4 * length)
                creep(next - at);
            else
                probe(next);
            at = next;
        }
        high = at;
    }

    // Moves the state in trial_ on by a very short step.
    void creep(double step) {
        const std::size_t n = trial_.size();
        for (std::size_t c = 0; c < n; ++c) stages_[c] = trial_[c] + 0.5 * step * k_trial_[c];
        derivative(stages_.data(), k_trial_.data());
        for (std::size_t c = 0; c < n; ++c) trial_[c] += step * k_trial_[c];
        derivative(trial_.data(), k_trial_.data());
    }

    double first_guess(int q, const Surface& a, const Surface& b, double length, double high) const {
        if (pairs[static_cast<std::size_t>(q)].fresh || !(a.smooth > 0.0 && b.smooth < 0.0))
            return 0.5 * high;
        const double chord = (b.smooth - a.smooth) / length;
        const double d = (a.smooth_slope + b.smooth_slope - 2.0 * chord) / (length * length);
        const double c = (3.0 * chord - 2.0 * a.smooth_slope - b.smooth_slope) / length;
        double low = 0.0, up = length, x = length * (a.smooth / (a.smooth - b.smooth));
        for (int i = 0; i < 20; ++i) {
            const double value = a.smooth + x * (a.smooth_slope + x * (c + x * d));
            const double slope = a.smooth_slope + x * (2.0 * c + 3.0 * x * d);
            (value > 0.0 ? low : up) = x;
            const double newton = x - value / slope;
            const double next = slope < 0.0 && newton > low && newton < up ? newton : 0.5 * (low + up);
            if (math::abs(next - x) <= 1e-6 * length) break;
            x = next;
        }
        return x < high ? x : 0.5 * high;
    }

    // To which a compression is known, as the difference of places [m]. What moves by less while others are in contact
    // does not begin to be.
    static double rounding(const Touching<Law>& q) { return 2.0 * math::epsilon * q.reach; }

    // A surface reached before this step begins, without being the one just left.
    template <class Height>
    bool at_surface(const Height& height) {
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            if (pairs[i].fresh) continue;
            const int q = static_cast<int>(i);
            for (const Event kind : events_of(pairs[i])) {
                if (kind == Event::none || height(q, kind) > 0.0) continue;
                if (kind == Event::begins &&
                    !(geometry(pairs[i], y_.data()).rate * time_unit() > rounding(pairs[i]))) {
                    pairs[i].fresh = true;  // touches without closing
                    continue;
                }
                apply(kind, q);
                return true;
            }
        }
        return false;
    }

    void apply(Event what, int index) {
        known_ = false;
        Touching<Law>& q = pairs[static_cast<std::size_t>(index)];
        const Geometry g = geometry(q, y_.data());
        q.fresh = true;
        if (what == Event::begins) {
            begin(index, g);
        } else if (what == Event::engages) {
            y_[loss()] -= q.law.energy(onset_root<p>(g.depth));
            begin(index, g);
        } else if (what == Event::ends) {
            end(index, g);
        } else if (what == Event::deepens) {
            too_deep = index;
        } else {
            q.touch = Touch::open;
        }
        h_ = 0.0;
    }

    void begin(int index, const Geometry& g) {
        Touching<Law>& q = pairs[static_cast<std::size_t>(index)];
        ++begun;
        begun_pairs += q.second >= 0;
        q.touch = Touch::closed;
        scale(q);
        q.begin = base + y_[clock()];
        q.impact_speed = g.rate;
        q.overlapped = false;
        for (Touching<Law>& other : pairs) {
            if (&other == &q || other.touch != Touch::closed || !share(q, other)) continue;
            q.overlapped = other.overlapped = true;
        }
    }

    static bool share(const Touching<Law>& a, const Touching<Law>& b) {
        return a.first == b.first || a.first == b.second ||
               (a.second >= 0 && (a.second == b.first || a.second == b.second));
    }

    void end(int index, const Geometry& g) {
        Touching<Law>& q = pairs[static_cast<std::size_t>(index)];
        ended.push_back({index, q.begin, base + y_[clock()], q.impact_speed, -g.rate, q.overlapped});
        const double s = math::max(root(index, g, y_.data()), 0.0);
        y_[loss()] += q.law.energy(s);
        if (q.rooted) {
            std::vector<int> chosen;
            for (const int other : rooted_)
                if (other != index) chosen.push_back(other);
            rearrange(chosen);
        }
        // Without slack the end is at touch: what overlaps there is rounding.
        q.touch = g.depth > 0.0 && q.law.slack(g.rate).depth > 0.0 ? Touch::slack : Touch::open;
    }
};

}  // namespace hardlimit::boxes

#include "linear.hpp"
