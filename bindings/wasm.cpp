// The core behind a C interface of plain numbers, for WebAssembly: conversion, nothing else. The same file compiled
// natively (web/golden.cpp) gives the values that the WebAssembly build is tested against, bit for bit.
//
// The caller writes a column to column_buffer() and calls a solver; results lie in reply_buffer(). Layout of the column:
//   [0] law, place in registry.hpp   [1] alternative   [2 … 5] parameters of the law, common ones first
//   [6] number of balls   [7] 1: floor, 0: cradle   [8] gravity [m/s²]
//   [9 + 4 i …] mass [kg], radius [m], gap below [m], velocity [m/s] of ball i, bottom first
#include "column/exact/drop.hpp"
#include "column/general/sample.hpp"
#include "column/independent.hpp"
#include "contact/registry.hpp"
#include "sweep/batch.hpp"
#include "sweep/linear_kernel.hpp"
#include "sweep/viscoelastic_entry.hpp"
#include "sweep/viscoelastic_kernel.hpp"

#include <type_traits>

namespace hl = hardlimit;
namespace col = hardlimit::column;
using hl::contact::LinearDashpot;
using hl::contact::Viscoelastic;

namespace {

constexpr int most_balls = 16;
constexpr int column_size = 9 + 4 * most_balls;
constexpr int reply_size = 16;
constexpr long most_steps = 300'000;  // a page must answer: later events than that are not shown

double request[column_size];
double reply[reply_size];

int balls() { return static_cast<int>(request[6]); }
bool on_floor() { return request[7] != 0.0; }

template <class Law>
constexpr int restitution_parameter() {
    return Law::record.n_common;
}

// The column as requested.
template <class Law>
col::Column<Law> make_column() {
    const int n = balls();
    col::Column<Law> c{n, on_floor(), request[8], {}, {}, {}, {}, {}};
    for (int i = 0; i < n; ++i) {
        const double* ball = request + 9 + 4 * i;
        c.mass.push_back(ball[0]);
        c.radius.push_back(ball[1]);
        c.gaps.push_back(ball[2]);
        c.velocity.push_back(ball[3]);
    }
    for (int j = 0; j < n; ++j) {
        const double below_mass = j == 0 ? hl::math::infinity : c.mass[j - 1];
        const double below_radius = j == 0 ? hl::math::infinity : c.radius[j - 1];
        const hl::PairGeometry pair{hl::effective(below_mass, c.mass[j]),
                                    hl::effective(below_radius, c.radius[j])};
        c.contacts.push_back(Law::from_parameters(static_cast<int>(request[1]), request + 2, pair));
    }
    return c;
}

// What is known of a state: [n] position, velocity, gap, force, mechanical energy (zero when all balls lie on each
// other and on the floor), then energy stored in the contacts and dissipated so far.
struct State {
    double *position, *velocity, *gap, *force, *energy, *stored, *dissipated;
    State(double* row, int n)
        : position(row),
          velocity(row + n),
          gap(row + 2 * n),
          force(row + 3 * n),
          energy(row + 4 * n),
          stored(row + 5 * n),
          dissipated(row + 5 * n + 1) {}
};
int state_size(int n) { return 5 * n + 2; }

// Positions and energies of the balls from gaps and velocities. A cradle has its first ball at `origin`.
template <class Law>
void complete(const col::Column<Law>& c, State& s, double origin) {
    double height = 0.0, z = origin;
    for (int i = 0; i < c.balls; ++i) {
        if (i > 0 || c.floor) height += s.gap[i];
        if (i > 0 || c.floor) z += (i > 0 ? c.radius[i - 1] : 0.0) + s.gap[i] + c.radius[i];
        s.position[i] = z;
        s.energy[i] = c.mass[i] * (0.5 * s.velocity[i] * s.velocity[i] + c.gravity * height);
    }
}

struct Solution {
    col::Sequence sequence;
    std::vector<col::Contact> contacts;
    double first = hl::math::nan, last = hl::math::nan;  // span that can be sampled
    double impact_speed = hl::math::nan;
    virtual ~Solution() = default;
    virtual void sample(double t, double* row) = 0;
};

struct Exact final : Solution {
    col::LinearColumn column;
    col::Drop drop;
    Exact(const col::LinearColumn& c, col::Coupling coupling, double until)
        : column(c), drop(col::solve_drop(c, coupling, until)) {
        sequence = drop.sequence;
        contacts = drop.contacts;
        if (drop.nodes.empty()) return;
        first = drop.nodes.front().t / drop.start.units.rate;
        last = drop.nodes.back().t / drop.start.units.rate;
    }
    void sample(double t, double* row) override {
        State s(row, 2);
        const col::DropSample d = col::sample_drop(column, drop, t);
        s.velocity[0] = d.du;
        s.velocity[1] = d.du + d.dw;
        s.gap[0] = d.u;
        s.gap[1] = d.w;
        s.force[0] = d.force_floor;
        s.force[1] = d.force_pair;
        *s.stored = d.stored;
        *s.dissipated = d.dissipated;
        complete(column, s, 0.0);
    }
};

template <class Law>
struct Integrated final : Solution {
    col::Column<Law> column;
    col::IntegrateOptions options;
    col::Integration<Law> run;
    double start = 0.0;
    Integrated(const col::Column<Law>& c, double until) : column(c) {
        options.until = until;
        options.record = true;
        options.max_steps = most_steps;
        run = col::integrate(column, options);
        sequence = run.sequence;
        contacts = run.contacts;
        if (run.intervals.empty()) return;
        first = run.intervals.front().t;
        last = run.intervals.back().t;
    }
    void sample(double t, double* row) override {
        State s(row, column.balls);
        col::Energies e{};
        col::sample(column, run, &t, 1, {s.gap, s.velocity, s.force, &e});
        *s.stored = e.contact;
        *s.dissipated = e.dissipated;
        complete(column, s, column.floor ? 0.0 : drift(t));
    }

private:
    // Position of the first ball of a cradle from the centre of mass, which moves uniformly.
    double drift(double t) const {
        double mass = 0.0, momentum = 0.0, above = 0.0;
        for (int i = 0; i < column.balls; ++i) {
            mass += column.mass[i];
            momentum += column.mass[i] * column.velocity[i];
        }
        std::vector<double> gaps(column.balls), rates(column.balls);
        col::sample(column, run, &t, 1, {gaps.data(), rates.data(), nullptr, nullptr});
        double offset = 0.0;
        for (int i = 1; i < column.balls; ++i) {
            offset += gaps[i] - column.gaps[i];
            above += column.mass[i] * offset;
        }
        return (momentum * t - above) / mass;
    }
};

template <class Law>
struct Independent final : Solution {
    col::Column<Law> column;
    col::IndependentRun run;
    double initial = 0.0;
    std::size_t at = 0;
    Independent(const col::Column<Law>& c, double until) : column(c), run(col::solve_independent(c, until)) {
        sequence = run.sequence;
        contacts = run.contacts;
        first = run.flights.front().t;
        last = hl::math::is_nan(until) ? run.flights.back().t : hl::math::max(until, run.flights.back().t);
        initial = total(run.flights.front(), nullptr);
    }
    void sample(double t, double* row) override {
        if (run.flights[at].t > t) at = 0;
        while (at + 1 < run.flights.size() && run.flights[at + 1].t <= t) ++at;
        col::Flight f = run.flights[at];
        col::independent::advance(column, f, t - f.t);
        *State(row, column.balls).dissipated = initial - total(f, row);
    }

private:
    double total(const col::Flight& f, double* row) const {
        std::vector<double> own(state_size(column.balls), 0.0);
        State s(row ? row : own.data(), column.balls);
        double sum = 0.0;
        for (int i = 0; i < column.balls; ++i) {
            s.gap[i] = f.gaps[i];
            s.velocity[i] = f.velocity[i];
            s.force[i] = 0.0;
        }
        *s.stored = 0.0;
        complete(column, s, column.floor ? 0.0 : f.lowest - column.gaps[0] - column.radius[0]);
        for (int i = 0; i < column.balls; ++i) sum += s.energy[i];
        return sum;
    }
};

enum Model { newton, adiabatic, independent, models };

Solution** solutions() {
    static Solution* slots[models] = {};
    return slots;
}

template <class Law>
Solution* solved(int model, double until) {
    const col::Column<Law> c = make_column<Law>();
    if (model == independent) return new Independent<Law>(c, until);
    if constexpr (std::is_same_v<Law, LinearDashpot>) {
        if (c.balls == 2 && c.floor)
            return new Exact(c, model == adiabatic ? col::Coupling::adiabatic : col::Coupling::full, until);
    }
    return model == newton ? new Integrated<Law>(c, until) : nullptr;
}

// f<Law>() for the law requested.
template <class F>
auto with_law(F&& f) {
    return request[0] == 0.0 ? f.template operator()<LinearDashpot>() : f.template operator()<Viscoelastic>();
}

double landing_speed() {
    return on_floor() ? col::impact_speed(request[9 + 2], request[9 + 3], request[8]) : hl::math::nan;
}

// Only the contacts of a run.
struct ContactsOnly {
    std::vector<col::Contact> contacts;
    long open[2] = {-1, -1};
    void node(const col::Node&) {}
    void clock_restarts(double t) {
        for (col::Contact& k : contacts) k = {k.pair, k.begin - t, k.end - t};
    }
    void begins(int pair, double t) {
        open[pair] = static_cast<long>(contacts.size());
        contacts.push_back({pair, t, hl::math::nan});
    }
    void ends(int pair, double t) { contacts[static_cast<std::size_t>(open[pair])].end = t; }
};

// Sequence of one point of a scan, and with a `contacts` what closed and when.
template <class Law>
col::Sequence run_point(const col::Column<Law>& c, col::Coupling coupling,
                        std::vector<col::Contact>* contacts) {
    if constexpr (std::is_same_v<Law, LinearDashpot>) {
        if (c.balls == 2 && c.floor) {
            const col::Start s = col::start_two_ball(
                c.contacts[0], c.contacts[1], c.mass[0], c.mass[1], c.gravity,
                {c.gaps[0], c.velocity[0], c.gaps[1], c.velocity[1] - c.velocity[0]}, coupling);
            col::Sequence q;
            q.outcome = s.outcome;
            if (s.outcome != hl::Outcome::ok) return q;
            if (!contacts) {
                col::NoRecorder none;
                q = col::run_two_ball(s.groups, s.first, s.t, -hl::math::infinity, none);
            } else {
                ContactsOnly record;
                q = col::run_two_ball(s.groups, s.first, s.t, -hl::math::infinity, record);
                const double t0 = hl::math::is_nan(q.t_first_touch) ? 0.0 : q.t_first_touch;
                for (col::Contact& k : record.contacts)
                    k = {k.pair, (k.begin - t0) / s.units.rate, (k.end - t0) / s.units.rate};
                *contacts = std::move(record.contacts);
            }
            col::to_si(q, s.units);
            return q;
        }
    }
    col::IntegrateOptions options;
    options.tolerance = 1e-10;  // a pixel does not show more
    options.max_steps = most_steps;
    col::Integration<Law> run = col::integrate(c, options);
    if (contacts) *contacts = std::move(run.contacts);
    return run.sequence;
}

// What a scan varies besides the coefficient of restitution.
enum Axis { pair_gap, radius_ratio };

// The lower ball's radius as a multiple of the second one's; height of its centre and density stay.
template <class Law>
void set_radius_ratio(col::Column<Law>& c, double ratio) {
    const double before = c.radius[0], now = ratio * c.radius[1], scale = now / before;
    c.radius[0] = now;
    c.mass[0] *= scale * scale * scale;
    c.gaps[0] += before - now;
}

template <class Law>
void set_contacts(col::Column<Law>& c, double restitution) {
    double parameters[hl::max_parameters];
    for (int i = 0; i < hl::max_parameters; ++i) parameters[i] = request[2 + i];
    parameters[restitution_parameter<Law>()] = restitution;
    for (int j = 0; j < c.balls; ++j) {
        const double mass = j == 0 ? hl::math::infinity : c.mass[j - 1];
        const double radius = j == 0 ? hl::math::infinity : c.radius[j - 1];
        c.contacts[j] =
            Law::from_parameters(static_cast<int>(request[1]), parameters,
                                 {hl::effective(mass, c.mass[j]), hl::effective(radius, c.radius[j])});
    }
}

// A cradle's first gap is only the way to the first collision.
template <class Law>
int first_gap(const col::Column<Law>& c) {
    return c.floor || c.balls == 2 ? 1 : 2;
}

// The column of each point in turn; contacts are kept while ε and the balls stay.
template <class Law>
struct Points {
    int axis;
    const double* points;
    col::Column<Law> base = make_column<Law>(), c = base;
    double known = hl::math::nan;  // ε that the contacts have now

    // Without its contacts; whether the lowest ball starts above the floor.
    bool move_to(long i) {
        const double y = points[2 * i + 1];
        if (axis == radius_ratio) {
            c = base;
            set_radius_ratio(c, y);
            known = hl::math::nan;
        } else {
            for (int j = first_gap(c); j < c.balls; ++j) c.gaps[j] = y;
        }
        return c.gaps[0] > 0.0 || !c.floor;
    }
    double restitution(long i) const { return points[2 * i]; }
    // With its contacts.
    const col::Column<Law>& column(long i) {
        if (restitution(i) != known) set_contacts(c, restitution(i));
        known = restitution(i);
        return c;
    }
    void write(long i, const col::Sequence& q, double* out) const {
        const double speed = col::impact_speed(c.gaps[0], c.velocity[0], c.gravity);
        out[3 * i] = q.outcome == hl::Outcome::invalid ? hl::math::nan : q.n_contacts;
        out[3 * i + 1] = col::effective_restitution(q.relative_velocity, speed) / restitution(i);
        out[3 * i + 2] = col::effective_restitution(q.separation_velocity, speed) / restitution(i);
    }
};

col::Sequence refused() {
    col::Sequence q;
    q.outcome = hl::Outcome::invalid;
    return q;
}

template <class Law>
void scan(int axis, long n, const double* points, double* out) {
    Points<Law> p{axis, points};
    for (long i = 0; i < n; ++i)
        p.write(i, p.move_to(i) ? run_point(p.column(i), col::Coupling::full, nullptr) : refused(), out);
}

// Two balls on a floor, many drops at once through the kernels of sweep/.
using Pair = hl::Vector<4>::Real;
using hl::sweep::Block;

// A point into the kernel of its law (false: it is not for it), and that kernel.
template <class Law>
struct Way;

template <>
struct Way<LinearDashpot> {
    static bool enter(Points<LinearDashpot>& p, long i, col::Start& s) {
        const col::Column<LinearDashpot>& c = p.column(i);
        s = col::start_two_ball(c.contacts[0], c.contacts[1], c.mass[0], c.mass[1], c.gravity,
                                {c.gaps[0], c.velocity[0], c.gaps[1], c.velocity[1] - c.velocity[0]},
                                col::Coupling::full);
        return s.outcome == hl::Outcome::ok && hl::math::is_finite(s.groups.gravity + s.first.w);
    }
    static void solve(const Block& b) { hl::sweep::solve_block<Pair>(b); }
};

template <>
struct Way<Viscoelastic> {
    hl::sweep::Rates rates;
    double restitution = hl::math::nan, argument;

    // Without contacts, which would solve some eight collisions each for the dissipative time.
    bool enter(const Points<Viscoelastic>& p, long i, col::Start& s) {
        if (p.restitution(i) != restitution) {
            restitution = p.restitution(i);
            argument = hl::sweep::LossTable::shared().argument(-hl::math::log(restitution));
        }
        const col::Column<Viscoelastic>& c = p.c;
        hl::sweep::Parameters q{c.radius[0],
                                c.radius[1],
                                hl::math::nan,
                                c.mass[0],
                                c.mass[1],
                                c.gaps[1],
                                c.gaps[0] + c.radius[0],
                                c.velocity[0],
                                c.velocity[1],
                                c.gravity,
                                {},
                                {}};
        for (int k = 0; k < hl::max_parameters; ++k) q.floor_law[k] = q.pair_law[k] = request[2 + k];
        const hl::sweep::Setting setting{hl::sweep::Model::newton, 1, false, false,
                                         restitution_parameter<Viscoelastic>()};
        return hl::sweep::enter_viscoelastic(setting, q, argument, argument, rates, s);
    }
    static void solve(const Block& b) {
        hl::sweep::solve_viscoelastic_block<Pair>(b, -24.0);  // a pixel does not show more
    }
};

template <class Law>
void scan_block(int axis, long n, const double* points, double* out) {
    constexpr int most = 512;
    static hl::sweep::Drops<most> drops;
    static int drop_of[most];  // a point; −1: not for the kernel
    Points<Law> p{axis, points}, again{axis, points};
    Way<Law> way;
    for (long first = 0; first < n; first += most) {
        const int count = static_cast<int>(n - first < most ? n - first : most);
        drops.count = 0;
        for (int i = 0; i < count; ++i) {
            col::Start s;
            drop_of[i] = -1;
            if (!p.move_to(first + i) || !way.enter(p, first + i, s)) continue;
            drop_of[i] = drops.count;
            drops.add(s);
        }
        way.solve(drops.block());
        for (int i = 0; i < count; ++i) {
            const bool lands = again.move_to(first + i);
            const int k = drop_of[i];
            col::Sequence q = refused();
            if (k >= 0 && !drops.left(k))
                q = drops.sequence(k);
            else if (lands)
                q = run_point(again.column(first + i), col::Coupling::full, nullptr);
            again.write(first + i, q, out);
        }
    }
}

template <class Law>
long timeline(int model, long n, const double* restitution, double* out, long room) {
    col::Column<Law> c = make_column<Law>();
    const col::Coupling coupling = model == adiabatic ? col::Coupling::adiabatic : col::Coupling::full;
    std::vector<col::Contact> contacts;
    long used = 0;
    for (long i = 0; i < n; ++i) {
        set_contacts(c, restitution[i]);
        contacts.clear();
        const col::Sequence q = run_point(c, coupling, &contacts);
        if (used + 4 + 3 * static_cast<long>(contacts.size()) > room) break;
        out[used++] = q.n_contacts;
        out[used++] = q.t_end;
        out[used++] = q.t_floor_end;
        out[used++] = static_cast<double>(contacts.size());
        for (const col::Contact& k : contacts) {
            out[used++] = k.pair;
            out[used++] = k.begin;
            out[used++] = k.end;
        }
    }
    return used;
}

}  // namespace

extern "C" {

double* column_buffer() { return request; }
double* reply_buffer() { return reply; }

// Room for `n` doubles, valid until the next call.
double* scratch(long n) {
    static double* room = nullptr;
    static long size = 0;
    if (n > size) {
        delete[] room;
        room = new double[static_cast<std::size_t>(n)];
        size = n;
    }
    return room;
}

// Solves the column requested: model 0 Newton's equations, 1 adiabatic (two balls, linear law), 2 independent
// collisions; until NaN: the sequence only. Reply: outcome, contacts of the sequence, t_end, t_floor_end, relative and
// separation velocity, first and last time, recorded contacts, speed at the floor, ε_eff of both velocities.
// Returns whether the model exists for this column.
int solve(int model, double until) {
    Solution*& slot = solutions()[model];
    delete slot;
    slot = with_law([&]<class Law>() { return solved<Law>(model, until); });
    if (!slot) return 0;
    const col::Sequence& q = slot->sequence;
    const double speed = landing_speed();
    const double values[] = {static_cast<double>(q.outcome),
                             static_cast<double>(q.n_contacts),
                             q.t_end,
                             q.t_floor_end,
                             q.relative_velocity,
                             q.separation_velocity,
                             slot->first,
                             slot->last,
                             static_cast<double>(slot->contacts.size()),
                             speed,
                             col::effective_restitution(q.relative_velocity, speed),
                             col::effective_restitution(q.separation_velocity, speed)};
    for (std::size_t i = 0; i < sizeof values / sizeof *values; ++i) reply[i] = values[i];
    return 1;
}

// Contacts of the last run as (pair, begin, end).
void contacts_of(int model, double* out) {
    for (const col::Contact& k : solutions()[model]->contacts) {
        *out++ = k.pair;
        *out++ = k.begin;
        *out++ = k.end;
    }
}

int row_size() { return state_size(balls()); }

// States at n times (rows of row_size()); times outside the run are moved to its ends.
void sample(int model, long n, const double* times, double* out) {
    Solution& s = *solutions()[model];
    const int size = row_size();
    for (long i = 0; i < n; ++i) s.sample(hl::math::clamp(times[i], s.first, s.last), out + i * size);
}

// n points (ε, gap) or (ε, R1/R2) → number of contacts, ε_eff/ε at the end of the sequence and at separation.
void scan_points(int axis, long n, const double* points, double* out) {
    with_law([&]<class Law>() {
        if (balls() == 2 && on_floor())
            scan_block<Law>(axis, n, points, out);
        else
            scan<Law>(axis, n, points, out);
    });
}

// Contacts for each ε: contacts of the sequence, t_end, t_floor_end, number k, then k times (pair, begin, end).
// Returns the doubles written.
long scan_timeline(int model, long n, const double* restitution, double* out, long room) {
    return with_law([&]<class Law>() { return timeline<Law>(model, n, restitution, out, room); });
}

const char* outcome_message(int outcome) { return hl::message(static_cast<hl::Outcome>(outcome)); }

}  // extern "C"
