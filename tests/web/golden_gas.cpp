// Golden values of the module of boxes of grains: settings, and what the native build makes of them.
#include "../../bindings/wasm_grains.cpp"

#include "golden.hpp"

namespace {

// Places in the registry of rules.
enum { constant, tc, by_law, soft };

struct Case {
    const char* name;
    int dimension, number;
    double fraction, spread;  // of the radii, relative
    int rule;
    double law[2 + hl::max_parameters];  // place, alternative, parameters; used by the rules law and soft
    bool walls;                          // across the last axis, with gravity along it
    double rows;                         // collisions for each particle
};

constexpr double viscoelastic[] = {1, 0, 1e7, 0.3, 1e-5, 0};
constexpr double linear[] = {0, 0, 1e4, 0.9, 0, 0};
#define HL_LAW(x) {x[0], x[1], x[2], x[3], x[4], x[5]}
const Case cases[] = {
    {"elastic disks", 2, 150, 0.5, 0.0, constant, {}, false, 30},
    {"elastic spheres", 3, 150, 0.45, 0.0, constant, {}, false, 30},
    {"mixed disks between walls, tc", 2, 100, 0.4, 0.6, tc, {}, true, 20},
    {"mixed spheres, viscoelastic", 3, 120, 0.3, 0.5, by_law, HL_LAW(viscoelastic), false, 20},
    {"spheres between walls, linear", 3, 100, 0.2, 0.0, by_law, HL_LAW(linear), true, 20},
    {"soft disks", 2, 80, 0.3, 0.0, soft, HL_LAW(viscoelastic), false, 15},
    {"soft mixed spheres between walls", 3, 60, 0.2, 0.4, soft, HL_LAW(linear), true, 10},
    {"few disks in a narrow box", 2, 3, 0.4, 0.0, constant, {}, false, 60},
};

// A setting without positions; velocities of the order of 1 m/s.
void write_setting(const Case& c) {
    double* const s = box_setting(c.dimension, c.number);
    const Arrays a = arrays();
    box::Random random(7);
    double filled = 0.0;
    for (int i = 0; i < c.number; ++i) {
        const double r = a.radius[i] = 1e-3 * (1.0 + c.spread * (random.uniform() - 0.5));
        a.mass[i] = 1e4 * r * r * r;
        filled += (c.dimension == 3 ? 4.0 / 3.0 * r : 1.0) * hl::math::pi * r * r;
        for (int k = 0; k < c.dimension; ++k) a.velocity[i * c.dimension + k] = random.normal();
    }
    const double volume = filled / c.fraction, edge = hl::math::pow(volume, 1.0 / c.dimension);
    for (int k = 0; k < c.dimension; ++k) s[edges + k] = edge, s[periodic + k] = 1.0;
    s[rule] = c.rule;
    s[law] = -1.0;
    s[restitution] = c.rule == constant ? 1.0 : 0.95;
    s[contact_duration] = 1e-5;
    if (c.rule == by_law || c.rule == soft) {
        s[law] = c.law[0];
        s[alternative] = c.law[1];
        std::copy_n(c.law + 2, hl::max_parameters, s + parameters);
    }
    if (!c.walls) return;
    s[periodic + c.dimension - 1] = 0.0;
    s[gravity + c.dimension - 1] = -9.81;
}

void print_hash(const char* name, const double* x, std::size_t n, const char* after) {
    Hash hash;
    for (std::size_t i = 0; i < n; ++i) hash.add(x[i]);
    hash.print(name, after);
}

void print_case(const Case& c, const char* after) {
    write_setting(c);
    const std::size_t nd = static_cast<std::size_t>(c.number) * static_cast<std::size_t>(c.dimension);
    const double rows = c.rows * c.number;
    std::printf("  {\"name\": \"%s\", \"dimension\": %d, \"number\": %d, \"rows\": %.0f,\n   ", c.name,
                c.dimension, c.number, rows);
    const std::vector<double>& setting = run().setting;
    print("setting", setting.data(), static_cast<long>(setting.size()), ",\n   ");
    std::printf("\"grown\": %d, ", box_grow(5));
    print_hash("positions", arrays().position, nd, ",\n   ");
    std::printf("\"refusal\": %d, ", box_start(1));
    std::printf("\"outcome\": %d, ", box_advance(hl::math::infinity, rows));
    print("observed", box_observe(), 17, ",\n   ");
    print_hash("state", box_state(), 2 * nd, ", ");
    const std::size_t logged = static_cast<std::size_t>(box_take_log());
    std::printf("\"logged\": %zu, ", logged);
    print_hash("log", box_log(), 4 * logged, "}");
    std::printf("%s\n", after);
}

}  // namespace

void print_boxes() {
    std::printf("\"boxes\": [\n");
    const std::size_t n = sizeof cases / sizeof *cases;
    for (std::size_t i = 0; i < n; ++i) print_case(cases[i], i + 1 < n ? "," : "");
    std::printf("]");
}
