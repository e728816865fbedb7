// C interface to the column solvers, for WebAssembly; it only converts numbers. The same file compiled natively
// (tests/web/golden.cpp) gives the reference values with which the WebAssembly build is compared, bit for bit.
//
// The caller writes a column to column_buffer() and calls a solver, which writes to reply_buffer(). Layout of the
// column:
//   [0] law, index in registry.hpp   [1] alternative   [2] number of balls   [3] 1: floor, 0: cradle
//   [4] gravity [m/s²]
//   [5 + 8 i …] mass [kg], radius [m], gap below [m], velocity [m/s] of ball i, bottom first; then the 4 parameters of
//   its contact with the body below, common ones first
#include <algorithm>
#include <array>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string_view>
#include <type_traits>
#include <vector>

// A visitor waits for the module: code that does not run for each point of a map is compiled for size.
#ifdef __clang__
#define HL_SMALL _Pragma("clang attribute push(__attribute__((minsize)), apply_to = function)")
#define HL_SMALL_END _Pragma("clang attribute pop")
#else
#define HL_SMALL
#define HL_SMALL_END
#endif
// clang-format off
#include "contact/registry.hpp"
#include "sweep/batch.hpp"
#include "sweep/linear_kernel.hpp"
#include "sweep/viscoelastic_entry.hpp"
#include "sweep/viscoelastic_kernel.hpp"
HL_SMALL
#include "base/radau.hpp"
HL_SMALL_END
#include "column/general/run.hpp"
HL_SMALL
#include "column/comparison.hpp"
#include "column/model.hpp"
#include "column/rebound.hpp"
#include "sweep/parameter_table.hpp"
// clang-format on

namespace hl = hardlimit;
namespace col = hardlimit::column;
using hl::contact::LinearDashpot;
using hl::contact::Viscoelastic;

namespace {

constexpr int most_balls = 16;
constexpr int head_size = 5;
constexpr int ball_size = 4 + hl::max_parameters;
constexpr int column_size = head_size + ball_size * most_balls;
constexpr int reply_size = 16;
constexpr long most_steps = 300'000;  // limits the time for one point of a scan

double request[column_size];
double reply[reply_size];

int balls() { return static_cast<int>(request[2]); }
bool on_floor() { return request[3] != 0.0; }
const double* ball(int i) { return request + head_size + ball_size * i; }
const double* parameters_of(int contact) { return ball(contact) + 4; }

// Index of ε among the parameters of a law in this alternative; −1 if it does not contain ε.
int restitution_parameter(const hl::LawRecord& law, int alternative) {
    for (int i = 0; i < law.n_in_alternative[alternative]; ++i)
        if (law.alternatives[alternative][i].name == std::string_view("restitution")) return law.n_common + i;
    return -1;
}
int alternative() { return static_cast<int>(request[1]); }

// Contact j of a column. The last ones are kept: along an axis of a map many are the same, and to build those of the
// viscoelastic law takes longer than the rest of a point.
template <class Law>
const Law& contact_of(int j, const double* parameters, const hl::PairGeometry& pair) {
    using Inputs = std::array<double, 3 + hl::max_parameters>;
    struct Known {
        Inputs inputs;
        std::optional<Law> law;
    };
    // The linker of WebAssembly would run a destructor after each call from outside.
    static_assert(std::is_trivially_destructible_v<Known>);
    static Known known[most_balls];
    Inputs inputs{static_cast<double>(alternative()), pair.effective_mass, pair.effective_radius};
    std::copy_n(parameters, hl::max_parameters, inputs.begin() + 3);
    Known& k = known[j];
    if (!k.law || std::memcmp(&k.inputs, &inputs, sizeof inputs) != 0)
        k = {inputs, Law::from_parameters(alternative(), parameters, pair)};
    return *k.law;
}

// Sets the contacts of a column. `restitution` replaces that of the request unless it is NaN.
template <class Law>
void set_contacts(col::Column<Law>& c, double restitution = hl::math::nan) {
    c.contacts.clear();
    for (int j = 0; j < c.balls; ++j) {
        const double mass = j == 0 ? hl::math::infinity : c.mass[j - 1];
        const double radius = j == 0 ? hl::math::infinity : c.radius[j - 1];
        const hl::PairGeometry pair{hl::effective(mass, c.mass[j]), hl::effective(radius, c.radius[j])};
        double parameters[hl::max_parameters];
        std::copy_n(parameters_of(j), hl::max_parameters, parameters);
        if (!hl::math::is_nan(restitution))
            parameters[restitution_parameter(Law::record, alternative())] = restitution;
        c.contacts.push_back(contact_of<Law>(j, parameters, pair));
    }
}

// The column in the request buffer.
template <class Law>
col::Column<Law> make_column() {
    const int n = balls();
    col::Column<Law> c{.balls = n, .floor = on_floor(), .gravity = request[4]};
    for (int i = 0; i < n; ++i) {
        c.mass.push_back(ball(i)[0]);
        c.radius.push_back(ball(i)[1]);
        c.gaps.push_back(ball(i)[2]);
        c.velocity.push_back(ball(i)[3]);
    }
    set_contacts(c);
    return c;
}

// Calls f<Law>() for the requested law.
template <class F>
auto with_law(F&& f) {
    int place = static_cast<int>(request[0]);
#define HL_CASE(Law) \
    if (place-- == 0) return f.template operator()<hl::contact::Law>();
    HARDLIMIT_LAWS(HL_CASE)
#undef HL_CASE
    return f.template operator()<LinearDashpot>();  // unreachable for a valid index
}

// Last solution of each model.
struct Solved {
    col::Model model;
    col::SolveOptions options;
    std::unique_ptr<col::Solution> found;
};

Solved& solved(int model) {
    static Solved* slots[3] = {};
    if (!slots[model]) slots[model] = new Solved{static_cast<col::Model>(model), {}, {}};
    return *slots[model];
}

// Row of a state: position, velocity, gap, force and mechanical energy (kinetic plus potential) of the balls, n values
// each; then the energy stored in the contacts and the energy dissipated so far.
int state_size(int n) { return 5 * n + 2; }
void write_row(const col::States& s, std::size_t i, double* row) {
    for (const std::vector<double>* values : {&s.position, &s.velocity, &s.gap, &s.force, &s.energy})
        row = std::copy_n(values->data() + i * s.balls, s.balls, row);
    *row++ = s.total[i].contact;
    *row = s.total[i].dissipated;
}

double landing_speed() {
    return on_floor() ? col::impact_speed(ball(0)[2], ball(0)[3], request[4]) : hl::math::nan;
}

// Options for one point of a scan, of which the page shows only one pixel.
col::SolveOptions coarse() {
    col::SolveOptions options;
    options.tolerance = 1e-10;
    options.max_steps = most_steps;
    return options;
}

// The quantity that a scan varies besides the coefficient of restitution.
enum Axis { pair_gap, radius_ratio };

// Sets the lower ball's radius to a multiple of the second one's, at constant density and height of its centre.
template <class Law>
void set_radius_ratio(col::Column<Law>& c, double ratio) {
    const double before = c.radius[0], now = ratio * c.radius[1], scale = now / before;
    c.radius[0] = now;
    c.mass[0] *= scale * scale * scale;
    c.gaps[0] += before - now;
}

// Index of the first gap that a scan varies. In a cradle the first gap only determines the time of the first collision.
template <class Law>
int first_gap(const col::Column<Law>& c) {
    return c.floor || c.balls == 2 ? 1 : 2;
}

// The column of each point of a scan. The contacts are recomputed only if ε or the balls change.
template <class Law>
struct Points {
    int axis;
    const double* points;
    col::Column<Law> base = make_column<Law>(), c = base;
    double known = hl::math::nan;  // ε of the current contacts

    // Sets the geometry of point i, without contacts. Returns whether the lowest ball starts above the floor.
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
    // The column of the current point, with contacts.
    const col::Column<Law>& column(long i) {
        if (restitution(i) != known) set_contacts(c, restitution(i));
        known = restitution(i);
        return c;
    }
    col::Sequence solve(long i) {
        return col::solve_sequence(column(i), col::Model::newton, coarse(), nullptr);
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
    for (long i = 0; i < n; ++i) p.write(i, p.move_to(i) ? p.solve(i) : refused(), out);
}

// Vector type for two-ball drops solved by the kernels of sweep/.
using Pair = hl::Vector<4>::Real;
using hl::sweep::Batch;

// Vector kernel of a law, for laws that have one. enter() converts a point to a drop; false if the kernel cannot solve
// it.
template <class Law>
struct Way;
template <class Law>
concept HasKernel = requires(const Batch& b) { Way<Law>::solve(b); };

template <>
struct Way<LinearDashpot> {
    static bool enter(Points<LinearDashpot>& p, long i, col::Start& s, col::CompressionBound& bound) {
        const col::Column<LinearDashpot>& c = p.column(i);
        bound = col::drop::bound_of(c, col::Coupling::full, hl::deepest_compression);
        s = col::drop::start_drop(c, col::Coupling::full);
        return s.outcome == hl::Outcome::ok && hl::math::is_finite(s.groups.gravity + s.first.w);
    }
    static void solve(const Batch& b) { hl::sweep::solve_batch<Pair>(b); }
};

template <>
struct Way<Viscoelastic> {
    hl::sweep::Rates rates;
    double restitution = hl::math::nan, argument;

    // Avoids constructing the contacts: each would solve about eight collisions for its dissipative time.
    bool enter(const Points<Viscoelastic>& p, long i, col::Start& s, col::CompressionBound& bound) {
        if (p.restitution(i) != restitution) {
            restitution = p.restitution(i);
            argument = hl::sweep::LossTable::shared().argument(-hl::math::log(restitution));
        }
        const col::Column<Viscoelastic>& c = p.c;
        hl::sweep::Parameters q{.radius_1 = c.radius[0],
                                .radius_2 = c.radius[1],
                                .radius_ratio = hl::math::nan,
                                .matter_1 = c.mass[0],
                                .matter_2 = c.mass[1],
                                .gap = c.gaps[1],
                                .height = c.gaps[0] + c.radius[0],
                                .velocity_1 = c.velocity[0],
                                .velocity_2 = c.velocity[1],
                                .gravity = c.gravity,
                                .floor_law = {},
                                .pair_law = {}};
        std::copy_n(parameters_of(0), hl::max_parameters, q.floor_law);
        std::copy_n(parameters_of(1), hl::max_parameters, q.pair_law);
        const hl::sweep::Setting setting{col::Model::newton, alternative(), false, false,
                                         restitution_parameter(Viscoelastic::record, alternative())};
        if (!hl::sweep::enter_viscoelastic(setting, q, argument, argument, rates, s)) return false;
        bound = hl::sweep::viscoelastic_bound(setting, q);
        return true;
    }
    static void solve(const Batch& b) {
        hl::sweep::solve_viscoelastic_batch<Pair>(b, -24.0);  // sufficient for one pixel
    }
};

template <class Law>
void scan_batch(int axis, long n, const double* points, double* out) {
    constexpr int most = 512;
    static hl::sweep::Drops<most> drops;
    static int drop_of[most];  // drop of a point; −1: not solved by the kernel
    static col::DropBound shallow[most];
    Points<Law> p{axis, points}, again{axis, points};
    Way<Law> way;
    for (long first = 0; first < n; first += most) {
        const int count = static_cast<int>(n - first < most ? n - first : most);
        drops.count = 0;
        for (int i = 0; i < count; ++i) {
            col::Start s;
            col::CompressionBound bound;
            drop_of[i] = -1;
            if (!p.move_to(first + i) || !way.enter(p, first + i, s, bound)) continue;
            shallow[i] = col::DropBound::of(bound, p.c.gaps[1], s.units.speed);
            if (!shallow[i].holds(0.0)) continue;
            drop_of[i] = drops.count;
            drops.add(s);
        }
        way.solve(drops.batch());
        for (int i = 0; i < count; ++i) {
            const bool lands = again.move_to(first + i);
            const int k = drop_of[i];
            col::Sequence q = refused();
            if (k >= 0 && !drops.unsolved(k)) q = drops.sequence(k);
            const bool known = k >= 0 && !drops.unsolved(k) && shallow[i].holds(q.n_contacts, q.t_end);
            if (!known && lands) q = again.solve(first + i);
            again.write(first + i, q, out);
        }
    }
}

template <class Law>
long timeline(int model, long n, const double* restitution, double* out, long room) {
    col::Column<Law> c = make_column<Law>();
    std::vector<col::Contact> contacts;
    long used = 0;
    for (long i = 0; i < n; ++i) {
        set_contacts(c, restitution[i]);
        contacts.clear();
        const col::Sequence q = col::solve_sequence(c, static_cast<col::Model>(model), coarse(), &contacts);
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

void write_comparison(const col::Comparison& c) {
    const double values[] = {static_cast<double>(c.answer),
                             static_cast<double>(c.ground),
                             static_cast<double>(c.overlapping),
                             c.error,
                             c.independent,
                             c.newton,
                             static_cast<double>(c.ball),
                             static_cast<double>(c.later)};
    std::copy(std::begin(values), std::end(values), reply);
}

// Whether the upper balls still approach each other when the lowest ball is back on the floor. Their later contacts are
// no part of the sequence, but count for the rebound heights.
bool upper_balls_meet_again(int model) {
    const Solved& slot = solved(model);
    const col::Solution& s = *slot.found;
    if (!on_floor() || !s.sequence.second_floor_contact || !hl::math::is_nan(slot.options.until))
        return false;
    return with_law([&]<class Law>() {
        double at;
        const auto column = std::make_shared<const col::Column<Law>>(make_column<Law>());
        return col::rebound::some_approach(
            col::rebound::end_of_sequence<Law>(column, slot.model, slot.options, s, at), 1);
    });
}

// See agreement_gaps().
template <class Law>
double agreement_gap(double restitution, double low, double high, double tolerance) {
    constexpr int steps = 160;
    col::Column<Law> c = make_column<Law>();
    set_contacts(c, restitution);
    col::SolveOptions options = coarse();
    options.max_events = 1000;
    double from = hl::math::infinity;
    bool at_the_top = true;
    for (int k = steps; k >= 0; --k) {
        const double gap = low * hl::math::exp(hl::math::log(high / low) * k / steps);
        for (int j = first_gap(c); j < c.balls; ++j) c.gaps[j] = gap;
        const auto column = std::make_shared<const col::Column<Law>>(c);
        const auto newton = col::solve_column(col::SharedColumn<Law>(column), col::Model::newton, options);
        const auto independent =
            col::solve_column(col::SharedColumn<Law>(column), col::Model::independent, options);
        const col::Comparison compared =
            col::compare_models(col::SharedColumn<Law>(column), options, *newton, *independent, tolerance);
        const bool agree = compared.error <= tolerance && compared.answer != col::Answer::no;
        if (k == steps && compared.answer == col::Answer::undecided) return hl::math::nan;
        if (!agree && k < steps && at_the_top) return from;
        if (agree && !at_the_top) return -gap;
        if (agree) from = gap;
        at_the_top = at_the_top && agree;
    }
    return from;
}

// The alternative that the page uses for a law: the first one with ε.
int page_alternative(const hl::LawRecord& law) {
    int a = 0;
    while (a + 1 < law.n_alternatives && restitution_parameter(law, a) < 0) ++a;
    return a;
}

// Calls f(parameter) for the parameters of a law, in the order of the column layout.
template <class F>
void each_parameter(const hl::LawRecord& law, F&& f) {
    const int a = page_alternative(law);
    for (int i = 0; i < law.n_common; ++i) f(law.common[i]);
    for (int i = 0; i < law.n_in_alternative[a]; ++i) f(law.alternatives[a][i]);
}

void write_line(std::vector<char>& text, std::initializer_list<std::string_view> fields) {
    char before = '\0';
    for (const std::string_view field : fields) {
        if (before) text.push_back(before);
        before = '\t';
        text.insert(text.end(), field.begin(), field.end());
    }
    text.push_back('\n');
}

#define HL_RECORD(Law) &hl::contact::Law::record,
const hl::LawRecord* const laws[] = {HARDLIMIT_LAWS(HL_RECORD)};
#undef HL_RECORD

}  // namespace

extern "C" {

double* column_buffer() { return request; }
double* reply_buffer() { return reply; }

// Memory for n doubles, valid until the next call.
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

// Solves the requested column. model: 0 Newton's equations, 1 adiabatic (two balls, linear law), 2 independent
// collisions. until: NaN ends with the sequence. most_events: limit on independent collisions, 0: the default. Reply:
// outcome, contacts of the sequence, t_end, t_floor_end, relative and separation velocity, first and last time, number
// of recorded contacts, impact speed, ε_eff of both velocities, largest compression over the smaller radius (NaN:
// none), pair that became too deep (−1: none), whether the upper balls meet again later. Returns whether the model
// applies to this column.
int solve(int model, double until, double most_events = 0.0) {
    Solved& slot = solved(model);
    slot.options = {};
    slot.options.until = until;
    if (most_events > 0.0) slot.options.max_events = static_cast<long>(most_events);
    slot.found = with_law([&]<class Law>() {
        return col::solve_column(std::make_shared<const col::Column<Law>>(make_column<Law>()), slot.model,
                                 slot.options);
    });
    if (!slot.found) return 0;
    const col::Sequence& q = slot.found->sequence;
    const double speed = landing_speed();
    const double values[] = {static_cast<double>(q.outcome),
                             static_cast<double>(q.n_contacts),
                             q.t_end,
                             q.t_floor_end,
                             q.relative_velocity,
                             q.separation_velocity,
                             slot.found->first,
                             slot.found->last,
                             static_cast<double>(slot.found->contacts.size()),
                             speed,
                             col::effective_restitution(q.relative_velocity, speed),
                             col::effective_restitution(q.separation_velocity, speed),
                             slot.found->largest_compression(),
                             static_cast<double>(slot.found->too_deep),
                             upper_balls_meet_again(model) ? 1.0 : 0.0};
    std::copy(std::begin(values), std::end(values), reply);
    return 1;
}

// Writes the contacts of the last run as (pair, begin, end).
void contacts_of(int model, double* out) {
    for (const col::Contact& k : solved(model).found->contacts) {
        *out++ = k.pair;
        *out++ = k.begin;
        *out++ = k.end;
    }
}

int row_size() { return state_size(balls()); }

// Writes the states at n times, in rows of row_size(). Times outside the run are clamped to it.
void sample(int model, long n, const double* times, double* out) {
    const col::Solution& s = *solved(model).found;
    std::vector<double> inside(times, times + n);
    for (double& t : inside) t = hl::math::clamp(t, s.first, s.last);
    col::States states(inside.size(), balls());
    s.sample(inside.data(), states);
    for (std::size_t i = 0; i < states.n; ++i, out += row_size()) write_row(states, i, out);
}

// Writes the rebound heights of the balls in the last run [m]; NaN where there is none.
void rebound_heights(int model, double* out) {
    const Solved& s = solved(model);
    const std::vector<double> heights = with_law([&]<class Law>() {
        const auto column = std::make_shared<const col::Column<Law>>(make_column<Law>());
        return col::rebound_heights(col::SharedColumn<Law>(column), s.model, s.options, *s.found);
    });
    std::copy(heights.begin(), heights.end(), out);
}

// Writes the velocities of the balls at the end of the last contact in the last run [m/s]; NaN where there are none.
void final_velocities(int model, double* out) {
    const std::vector<double> found =
        col::final_velocities(*solved(model).found, balls(), solved(model).options.until);
    std::copy(found.begin(), found.end(), out);
}

// Compares the last runs by independent collisions and by Newton's equations. Writes to reply_buffer(): answer, ground,
// overlapping contacts, error, velocity by independent collisions, by Newton's equations, ball (−1: separation
// velocity), later (comparison.hpp).
void compare_models(double tolerance) {
    write_comparison(with_law([&]<class Law>() {
        const auto column = std::make_shared<const col::Column<Law>>(make_column<Law>());
        return col::compare_models(col::SharedColumn<Law>(column), solved(0).options, *solved(0).found,
                                   *solved(2).found, tolerance);
    }));
}

// For n values of ε, writes the gap above which both models agree: all larger gaps up to `high` do, in logarithmic
// steps. −gap: they do not agree at `high`, but at this narrower gap, the widest one. Infinity: they agree at no gap.
// NaN: at `high` one of the models has no answer. Other gaps of the column stay unless the scan varies them too.
void agreement_gaps(long n, const double* restitution, double low, double high, double tolerance,
                    double* out) {
    with_law([&]<class Law>() {
        for (long i = 0; i < n; ++i) out[i] = agreement_gap<Law>(restitution[i], low, high, tolerance);
    });
}

// For n points (ε, gap) or (ε, R1/R2), writes the number of contacts and ε_eff/ε at the end of the sequence and at
// separation.
void scan_points(int axis, long n, const double* points, double* out) {
    with_law([&]<class Law>() {
        if constexpr (HasKernel<Law>) {
            if (balls() == 2 && on_floor()) return scan_batch<Law>(axis, n, points, out);
        }
        scan<Law>(axis, n, points, out);
    });
}

// For each ε, writes the number of contacts of the sequence, t_end, t_floor_end, a number k, then k times (pair, begin,
// end). Returns the number of doubles written.
long scan_timeline(int model, long n, const double* restitution, double* out, long room) {
    return with_law([&]<class Law>() { return timeline<Law>(model, n, restitution, out, room); });
}

// The records of the core as lines of tab-separated fields. For each law: "law", name, alternative, then for each of
// its parameters, in the order of the column layout: "parameter", name, unit, meaning. For each parameter of a column:
// "swept", name, unit, meaning. For each model: "model", name, label, abbreviation.
const char* records() {
    static std::vector<char> text;
    text.clear();
    for (const hl::LawRecord* law : laws) {
        const char alternative[] = {static_cast<char>('0' + page_alternative(*law)), '\0'};
        write_line(text, {"law", law->name, alternative});
        each_parameter(*law, [&](const hl::Parameter& p) {
            write_line(text, {"parameter", p.name, p.unit, p.meaning});
        });
    }
    for (const hl::sweep::SweptRecord& r : hl::sweep::swept_records)
        write_line(text, {"swept", r.name, r.unit, r.meaning});
    for (const col::ModelRecord& m : col::model_records)
        write_line(text, {"model", m.name, m.label, m.abbreviation});
    text.push_back('\0');
    return text.data();
}

// Writes the lowest and highest value of each "parameter" and "swept", in the order of records().
void record_ranges(double* out) {
    const auto write = [&](double lowest, double highest) {
        *out++ = lowest;
        *out++ = highest;
    };
    for (const hl::LawRecord* law : laws)
        each_parameter(*law, [&](const hl::Parameter& p) { write(p.lowest, p.highest); });
    for (const hl::sweep::SweptRecord& r : hl::sweep::swept_records) write(r.lowest, hl::math::infinity);
}

const char* outcome_message(int outcome) { return hl::message(static_cast<hl::Outcome>(outcome)); }

}  // extern "C"

HL_SMALL_END
