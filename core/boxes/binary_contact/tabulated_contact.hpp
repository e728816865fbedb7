// Fast evaluation of the contacts of planar_contact.hpp for event-driven runs: polynomials fitted to that solver, to
// the accuracy stated below. A contact takes about 0.2 µs.
//
// Scaling: let v_l be the speed at which an elastic impact would be l deep, v_l² = 2E(l)/m, and D the damping force at
// the compression l and the rate v_l, in units of m v_l²/l. For a PowerLaw (law.hpp) the contact, in units
// of its own speed and depth, depends only on v_n/v_l, D and v_t/v_n, for any bodies. If D is the same for all pairs
// (equal bodies, or a law whose restitution is given) there are two variables, otherwise three. Any other law has
// polynomials for one kind of pair only.
//
// Variables: ln(v_n/v_l)², ln D, and for the direction y = (1 + κ/b)^{−1/p}, p = Law::onset_power, which runs from 1
// (head-on) to 0 (grazing: the path leaves before any force acts). Here κ = λ v_t²/v_n² is the centrifugal acceleration
// in units of that of an elastic impact, and λ ≈ the depth of that impact in units of l. At κ ≈ −ε, where the
// centrifugal force would pull inwards, a contact would not end. This singularity is the nearest to κ = 0; hence
// b = ε/2 of the head-on impact. The unit of length is λ l/(1 + κ), the unit of time that length divided by v_n. Then
// the four functions are of order 1 in all limits: duration, residual compression, 1 − radial speed/v_n, and the
// relative excess of the turn over v_t/l times the duration. For an undamped contact the second and the third function
// are zero, and no energy is lost.
//
// A cell is fitted when it is first needed, and compared with the solver between the nodes. A cell that misses the
// accuracy is not used; of the virial, which no motion depends on, only ∫ (dξ/dt)² dt is compared. With two variables
// there are several sets of cells of different widths in speed: slow contacts depend so little on their speed that one
// wide cell suffices; if it misses the accuracy, narrow ones are used. If λ = v_n/v_l exactly, as under a linear law,
// the contact depends smoothly on λ down to 0: then λ is the variable of the first set, and one cell covers all slow
// contacts. The solver is called if there is no cell, at a wall with gravity along its normal, and for pairs of another
// kind. The result depends only on the arguments of the call and of the
// constructor, not on earlier calls.
#pragma once
#include <memory>
#include <type_traits>
#include <vector>

#include "../kernels/polynomial_cell.hpp"
#include "planar_contact.hpp"

namespace hardlimit::boxes {

// A law with its damping multiplied by a factor; the damping force must be proportional to the rate.
template <class Law>
struct ScaledDamping {
    static constexpr int onset_power = Law::onset_power;
    const Law* law;
    double factor;

    double force(double s, double rate) const { return law->force(s, factor * rate); }
    double elastic_force(double s) const { return law->elastic_force(s); }
    double energy(double s) const { return law->energy(s); }
    Slack slack(double rate) const {
        const Slack slack = law->slack(factor * rate);
        return {slack.depth, factor * slack.slope};
    }
};

// `virial`: also gives ∫ (dξ/dt)² dt, the greatest compression, and the components nt and tt of the virial, which are
// NaN otherwise; takes 50 % longer.
template <class Law, bool virial = false>
class TabulatedContacts {
public:
    static constexpr double accuracy = 1e-10;  // of duration, speeds and turn, relative to the impact

    using ReadCell = void (*)(const void* cell, const double* x, double* values);

    // Tables for pairs like this one. `damping_varies`: D differs between pairs. `reads`: a build of read_wide_cell.
    TabulatedContacts(const Law& law, double effective_mass, double distance, bool damping_varies,
                      ReadCell reads = nullptr)
        : law_(law),
          reads_(reads),
          mass_(effective_mass),
          distance_(distance),
          own_(reduce(law, effective_mass, distance)),
          varies_(damping_varies && similar && own_.damping > 0.0),
          deep_(varies_ ? speeds * slants * dampings : 0) {
        law.values(values_);
        if (varies_) {
            levels_.push_back(level(1.0, speeds, 0.2));
        } else {
            if (depth_grows_with_speed()) levels_.push_back(level_of_depths(0.02, 16, 0.02));
            levels_.push_back(level(2.0, speeds / 4, 0.02));
            levels_.push_back(level(0.5, speeds, 0.2));
        }
    }

    // D of a pair, for the caller to determine `damping_varies`.
    static double damping(const Law& law, double effective_mass, double distance) {
        return reduce(law, effective_mass, distance).damping;
    }

    PlanarContact operator()(const Law& law, const Approach& a) {
        const bool simple =
            a.gravity == 0.0 && a.normal_speed >= slowest_approach && a.tangential_speed >= 0.0;
        const bool own = is_own(law, a);
        const Reduced reduced = own ? own_ : reduce(law, a.effective_mass, length_of(a));
        if (!simple || !(own || covers(reduced))) return solve_planar_contact<virial>(law, a);
        const double speed = a.normal_speed * reduced.per_speed, speed2 = speed * speed;
        Places at{};
        if (varies_) at.damping = damping_of(reduced);
        for (Level& level : levels_) {
            double depth = speed;
            at.speed =
                level.of_depths ? place_of(speed * level.per_width, level.cells) : place_of(level, speed2);
            if (!(math::abs(at.speed.x) <= 1.0 && math::abs(at.damping.x) <= 1.0)) continue;
            const int row = row_of(at);
            if (!(level.bends[row] > 0.0)) level.bends[row] = bend(level, at);
            if (!level.of_depths) depth = depth_at(level, at.speed);
            const DirectionCoordinate slant = slant_of(a, depth, level.bends[row]);
            at.slant = {slant.cell, slant.x};
            const int slot = row * slants + slant.cell;
            if (varies_ ? fitted(deep_[slot], level, at) : fitted(level.flat[slot], level, at))
                return varies_ ? read(*deep_[slot].cell, a, at, slant.part)
                               : read(*level.flat[slot].cell, a, at, slant.part);
        }
        return solve_planar_contact<virial>(law, a);
    }

private:
    static constexpr int p = Law::onset_power;
    static constexpr bool similar = PowerLaw<Law>;
    static constexpr int speeds = 128, slants = 16, dampings = 48;
    static constexpr double highest = -2.0;                               // ln(v_n/v_l)² where the cells end
    static constexpr double damping_width = 0.5, lowest_damping = -18.0;  // in ln D
    static constexpr int functions = virial ? 8 : 4;
    using Flat = PolynomialCell<2, 8, functions>;
    using Deep = PolynomialCell<3, 8, functions>;
    using Values = Flat::Values;

    struct Reduced {
        double energy;     // 2E(l)
        double per_speed;  // 1/v_l
        double damping;    // D
    };
    // A cell of one variable, and the coordinate in it, −1 … 1.
    struct Place {
        int cell;
        double x;
    };
    struct Places {
        Place slant, speed, damping;
    };
    // λ in the middle of a cell of speeds, and the increase of ln λ from there to the edge.
    struct Depth {
        double middle, growth;
    };
    template <class Cell>
    struct Slot {
        std::unique_ptr<Cell> cell;
        bool tried = false;  // whether the fit has been tried
    };
    struct Level {
        double width, per_width;  // of a cell, in ln v_n² or in λ
        int cells;                // number of cells
        double error;             // tolerated at the test points, in units of the accuracy
        bool of_depths = false;   // the variable is λ = v_n/v_l
        std::vector<Depth> depths = {};
        std::vector<double> bends = {};     // b [cells or cells × dampings]; 0 if not yet known
        std::vector<Slot<Flat>> flat = {};  // if D is the same for all pairs
    };

    Law law_;
    ReadCell reads_;
    double mass_, distance_;
    Reduced own_;
    bool varies_;
    double values_[max_parameters] = {};
    std::vector<Level> levels_;  // the widest cells first
    std::vector<Slot<Deep>> deep_;

    Level level(double width, int cells, double error) const {
        Level made{.width = width, .per_width = 1.0 / width, .cells = cells, .error = error};
        made.bends.resize(cells * (varies_ ? dampings : 1), 0.0);
        made.flat.resize(varies_ ? 0 : cells * slants);
        for (int i = 0; i < cells; ++i) {
            const double begin = elastic_depth(made, i), end = elastic_depth(made, i + 1);
            made.depths.push_back({math::sqrt(begin * end), 0.5 * math::log(end / begin)});
        }
        return made;
    }
    Level level_of_depths(double width, int cells, double error) const {
        Level made{
            .width = width, .per_width = 1.0 / width, .cells = cells, .error = error, .of_depths = true};
        made.bends.resize(cells, 0.0);
        made.flat.resize(cells * slants);
        return made;
    }
    // Whether the depth of an elastic impact is proportional to its speed.
    bool depth_grows_with_speed() const {
        for (const double speed2 : {0.1, 1e-9})
            if (!(math::abs(elastic_depth(speed2) / math::sqrt(speed2) - 1.0) < 1e-12)) return false;
        return true;
    }
    int row_of(const Places& at) const {
        return varies_ ? at.speed.cell * dampings + at.damping.cell : at.speed.cell;
    }

    // ln(v_n/v_l)² at a coordinate that counts cells.
    static double speed_at(const Level& level, double cell) {
        return highest + level.width * (cell - level.cells);
    }
    // λ at the lower edge of a cell of speeds.
    double elastic_depth(const Level& level, int cell) const {
        return elastic_depth(math::exp(speed_at(level, cell)));
    }
    // Depth of an elastic impact in units of l, from (v_n/v_l)².
    double elastic_depth(double speed2) const {
        const auto stored = [&](double s) { return law_.energy(s); };
        const double energy = 0.5 * own_.energy * speed2;
        return math::power<p>(roots::solve_power(stored, energy)) / distance_;
    }
    // The first terms of the exponential function, two at a time: a short chain of dependent operations.
    static double near_exp(double g) {
        const double g2 = g * g, g4 = g2 * g2;
        const double a = (1.0 + g) + g2 * (1.0 / 2.0 + g * (1.0 / 6.0));
        const double b = (1.0 / 24.0 + g * (1.0 / 120.0)) + g2 * (1.0 / 720.0 + g * (1.0 / 5040.0));
        return a + g4 * (b + g4 * (1.0 / 40320.0 + g * (1.0 / 362880.0)));
    }
    // An approximate depth suffices for λ: its error does not make the functions less smooth.
    static double depth_at(const Level& level, const Place& speed) {
        if (level.of_depths) return level.width * (speed.cell + 0.5 * (speed.x + 1.0));
        const Depth& depth = level.depths[speed.cell];
        return depth.middle * near_exp(depth.growth * speed.x);
    }

    // A contact at a wall does not depend on l, so any length will do.
    double length_of(const Approach& a) const {
        return a.distance == math::infinity ? distance_ : a.distance;
    }

    static Reduced reduce(const Law& law, double mass, double distance) {
        const double s = onset_root<p>(distance), energy = 2.0 * law.energy(s);
        const double speed = math::sqrt(energy / mass);
        return {energy, 1.0 / speed, (law.force(s, speed) - law.force(s, 0.0)) * distance / energy};
    }

    // Whether this is the pair of the constructor.
    bool is_own(const Law& law, const Approach& a) const {
        if (a.effective_mass != mass_ || a.distance != distance_) return false;
        double values[max_parameters] = {};
        law.values(values);
        for (int i = 0; i < Law::record.n_constants; ++i)
            if (values[i] != values_[i]) return false;
        return true;
    }
    // Whether the polynomials hold for this other pair.
    bool covers(const Reduced& reduced) const {
        return similar && (varies_ || math::abs(reduced.damping - own_.damping) <= 1e-13 * own_.damping);
    }

    // `at` counts cells. Outside the cells, |x| > 1.
    static Place place_of(double at, int cells) {
        const int cell = static_cast<int>(math::clamp(at, 0.0, cells - 1.0));
        return {cell, 2.0 * (at - cell) - 1.0};
    }
    static Place place_of(const Level& level, double speed2) {
        return place_of(level.cells + (math::log(speed2) - highest) / level.width, level.cells);
    }
    static Place damping_of(const Reduced& reduced) {
        return place_of((math::log(reduced.damping) - lowest_damping) / damping_width, dampings);
    }
    // Has no Place as a member: copying it just after its parts are written would stall (store forwarding).
    struct DirectionCoordinate {
        int cell;
        double x;
        double part;  // the unit of length in units of l
    };
    static DirectionCoordinate slant_of(const Approach& a, double depth, double bend) {
        const double normal = a.normal_speed * a.normal_speed;
        const double sideways = a.distance == math::infinity ? 0.0 : a.tangential_speed;
        const double across = depth * (sideways * sideways), bent = bend * normal;
        const double y = onset_root<p>(bent / (bent + across));
        const Place at = place_of(slants * y, slants);
        return {at.cell, at.x, depth * (normal / (normal + across))};
    }
    // b in the middle of a cell.
    double bend(const Level& level, const Places& cell) const {
        const Places middle{{0, 0.0}, {cell.speed.cell, 0.0}, {cell.damping.cell, 0.0}};
        const Approach a{mass_, distance_, normal_speed(level, middle), 0.0, 0.0};
        const PlanarContact end = solve(a, middle);
        return end.outcome == Outcome::ok ? math::clamp(0.5 * end.radial_speed / a.normal_speed, 0.005, 0.5)
                                          : 0.5;
    }

    template <class Cell>
    PlanarContact read(const Cell& cell, const Approach& a, const Places& at, double part) const {
        const double x[3] = {at.slant.x, at.speed.x, at.damping.x};
        if constexpr (std::is_same_v<Cell, WideCell>)
            if (reads_) {
                double values[functions];
                reads_(&cell, x, values);
                return scaled(a, part, load_lanes<Values>(values));
            }
        return scaled(a, part, cell(x));
    }

    // The contact, from the fitted functions; `part`: the unit of length in units of l.
    PlanarContact scaled(const Approach& a, double part, const Values& f) const {
        const double unit = part * length_of(a);
        const double duration = f[0] * (unit / a.normal_speed), left = f[1] * unit;
        const double lost = f[2] * a.normal_speed;
        const double turn = a.tangential_speed / a.distance * duration * (1.0 + part * f[3]);
        const double across = tangential_speed(a, left);
        PlanarContact end{.outcome = Outcome::ok,
                          .duration = duration,
                          .turn = turn,
                          .compression = left,
                          .radial_speed = a.normal_speed - lost,
                          .tangential_speed = across,
                          .speed_loss = lost};
        if constexpr (virial) {
            end.rate_square = f[4] * (a.normal_speed * a.normal_speed * duration);
            end.greatest = f[5] * unit;
            const double turning = turn > 0.0 ? turn * (a.normal_speed * a.distance) : 0.0;  // 0 at a wall
            end.virial_nt = f[6] * turning;
            end.virial_tt = f[7] * (turning * turn);
        }
        return end;
    }
    static Values functions_of(const Approach& a, double part, const PlanarContact& end) {
        const double unit = part * a.distance;
        const double straight = a.tangential_speed * end.duration / a.distance;
        Values f{end.duration * (a.normal_speed / unit), end.compression / unit,
                 end.speed_loss / a.normal_speed, (end.turn - straight) / (straight * part)};
        if constexpr (virial) {
            f[4] = end.rate_square / (a.normal_speed * a.normal_speed * end.duration);
            f[5] = end.greatest / unit;
            f[6] = end.virial_nt / (a.normal_speed * a.distance * end.turn);
            f[7] = end.virial_tt / (a.normal_speed * a.distance * (end.turn * end.turn));
        }
        return f;
    }

    // ---- fitting --------------------------------------------------------------------------------------

    // The contact at a point of a cell.
    struct Point {
        Approach approach;
        double part;
        PlanarContact end;
    };
    Point solve_at(const Level& level, Places at, const double* x, int dims) const {
        at.slant.x = x[0];
        at.speed.x = x[1];
        if (dims == 3) at.damping.x = x[2];
        const double depth = depth_at(level, at.speed), normal = normal_speed(level, at);
        const double bent = level.bends[row_of(at)];
        const double y = (at.slant.cell + 0.5 * (at.slant.x + 1.0)) / slants;
        const double t = math::power<p>(y), swing = bent * (1.0 - t) / t;  // λ v_t²/v_n²
        const Approach a{mass_, distance_, normal, normal * math::sqrt(swing / depth), 0.0};
        return {a, depth / (1.0 + swing), solve(a, at)};
    }
    double normal_speed(const Level& level, const Places& at) const {
        const double place = at.speed.cell + 0.5 * (at.speed.x + 1.0);
        const double part = level.of_depths ? level.width * place : math::exp(0.5 * speed_at(level, place));
        return math::sqrt(own_.energy / mass_) * part;
    }
    // Solves for the pair of the constructor, with the damping of the cell if damping varies.
    PlanarContact solve(const Approach& a, const Places& at) const {
        if constexpr (similar) {
            if (varies_) {
                const double place = at.damping.cell + 0.5 * (at.damping.x + 1.0);
                const double damping = math::exp(lowest_damping + damping_width * place);
                return solve_planar_contact<virial>(ScaledDamping<Law>{&law_, damping / own_.damping}, a);
            }
        }
        return solve_planar_contact<virial>(law_, a);
    }

    // Whether the cell can be used; fits it on first use.
    template <class Cell>
    bool fitted(Slot<Cell>& slot, const Level& level, const Places& at) const {
        if (!slot.tried) fit(slot, level, at);
        return slot.cell != nullptr;
    }
    template <class Cell>
    void fit(Slot<Cell>& slot, const Level& level, const Places& at) const {
        constexpr int dims = Cell::dimensions;
        slot.tried = true;
        std::vector<Values> values(Cell::grid);
        for (int i = 0; i < Cell::grid; ++i) {
            if (!Cell::wanted(i)) continue;
            double x[3] = {};
            for (int d = 0; d < dims; ++d) x[d] = Cell::coordinate(i, d);
            const Point point = solve_at(level, at, x, dims);
            if (point.end.outcome != Outcome::ok) return;
            values[i] = functions_of(point.approach, point.part, point.end);
        }
        const Cell cell = Cell::through(values.data());
        if (holds(cell, level, at)) slot.cell = std::make_unique<Cell>(cell);
    }

    // Whether the polynomials are accurate enough near the corners, where they are worst, and inside.
    template <class Cell>
    bool holds(const Cell& cell, const Level& level, const Places& at) const {
        constexpr int dims = Cell::dimensions, corners = 1 << dims;
        for (int i = 0; i <= corners; ++i) {
            double x[3] = {0.1, -0.15, 0.2};
            for (int d = 0; i < corners && d < dims; ++d) x[d] = (i >> d & 1) ? 0.97 : -0.97;
            const Point point = solve_at(level, at, x, dims);
            if (point.end.outcome != Outcome::ok) return false;
            if (!(error(scaled(point.approach, point.part, cell(x)), point) <= level.error * accuracy))
                return false;
        }
        return true;
    }
    static double error(const PlanarContact& read, const Point& point) {
        const PlanarContact& end = point.end;
        const double speed = point.approach.normal_speed, unit = point.part * point.approach.distance;
        const double shape =
            math::max(math::abs(read.duration / end.duration - 1.0), math::abs(read.turn / end.turn - 1.0));
        const double rest = math::max(math::abs(read.speed_loss - end.speed_loss) / speed,
                                      math::abs(read.compression - end.compression) / unit);
        double square = 0.0;
        if constexpr (virial) square = math::abs(read.rate_square / end.rate_square - 1.0);
        return math::max(math::max(shape, rest), square);
    }
};

}  // namespace hardlimit::boxes
