// Prints the golden values of the page's core as JSON: solutions of columns, a hash over a large map, boxes of grains.
// golden.sh writes them to tests/data/golden_wasm.json; golden.test.mjs compares the WebAssembly build with them.
#include "../../bindings/wasm.cpp"

#include <array>

#include "golden.hpp"

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double nan = hardlimit::math::nan;

struct Case {
    const char* name;
    std::vector<double> column;
    double until;  // of the second run of each model
};

double sphere(double density, double radius) { return density * (4.0 / 3.0) * pi * radius * radius * radius; }

std::vector<double> linear(double stiffness, double restitution) {
    return {0, 0, stiffness, restitution, 0, 0};
}
std::vector<double> viscous(double young, double poisson, double restitution, double speed) {
    return {1, 1, young, poisson, restitution, speed};
}

// balls: radius, density, gap below, velocity
std::vector<double> make(std::vector<double> law, bool floor, std::vector<std::array<double, 4>> balls) {
    std::vector<double> column = {law[0], law[1], static_cast<double>(balls.size()), floor ? 1.0 : 0.0,
                                  floor ? 9.81 : 0.0};
    for (const auto& [radius, density, gap, velocity] : balls)
        column.insert(column.end(),
                      {sphere(density, radius), radius, gap, velocity, law[2], law[3], law[4], law[5]});
    return column;
}

std::vector<Case> cases() {
    const auto two = [](double lower, double upper, double gap) {
        return std::vector<std::array<double, 4>>{{lower, 840.0, 0.6 - lower, 0.0}, {upper, 840.0, gap, 0.0}};
    };
    std::vector<std::array<double, 4>> stack = {{0.027, 950.0, 0.473, 0.0},
                                                {0.019, 950.0, 5e-5, 0.0},
                                                {0.0135, 950.0, 5e-5, 0.0},
                                                {0.009, 950.0, 5e-5, 0.0}};
    std::vector<std::array<double, 4>> cradle(5, {0.01, 7850.0, 0.0, 0.0});
    cradle[0][3] = 1.0;
    cradle[1][2] = 0.05;
    return {
        {"paper, Fig. 2", make(linear(5e7, 0.7), true, two(0.1, 0.01, 1e-4)), 0.2},
        {"elastic", make(linear(5e7, 1.0), true, two(0.1, 0.01, 1e-4)), 0.2},
        {"overdamped", make(linear(5e7, 0.05), true, two(0.1, 0.01, 1e-4)), 0.05},
        {"touching", make(linear(4e4, 0.8), true, two(0.12, 0.033, 0.0)), 0.1},
        {"far apart", make(linear(5e7, 0.9), true, two(0.1, 0.01, 0.05)), 0.2},
        {"viscoelastic, Fig. 7", make(viscous(5e7, 0.45, 0.7, 3.0), true, two(0.1, 0.0025, 1e-4)), 0.05},
        {"stack of four", make(linear(5e5, 0.85), true, stack), 0.1},
        {"cradle of five", make(viscous(2.1e11, 0.3, 0.97, 1.0), false, cradle), 0.06},
    };
}

void print_run(int model, double until) {
    if (!solve(model, until)) {
        std::printf("null");
        return;
    }
    const std::vector<double> head(reply_buffer(), reply_buffer() + 12);
    const long n = static_cast<long>(head[8]);
    std::vector<double> contacts(3 * static_cast<std::size_t>(n) + 1);
    contacts_of(model, contacts.data());
    std::vector<double> times, states(9 * static_cast<std::size_t>(row_size()));
    for (int i = 0; i < 9; ++i) times.push_back(head[6] + (head[7] - head[6]) * (i / 8.0));
    sample(model, 9, times.data(), states.data());
    std::printf("{");
    print("reply", head.data(), 12, ",\n     ");
    print("contacts", contacts.data(), 3 * n, ",\n     ");
    print("times", times.data(), 9, ",\n     ");
    print("states", states.data(), static_cast<long>(states.size()), "}");
}

// side² points: ε = (i + 1/2)/side above 0.02, gap = 1e-8 (j + 1)² m or R1/R2 = 0.5 + 0.05 j.
void print_map(const char* name, const Case& c, int axis, int side, const char* after) {
    std::memcpy(column_buffer(), c.column.data(), 8 * c.column.size());
    std::vector<double> points, out(3 * static_cast<std::size_t>(side) * side);
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) {
            points.push_back(0.02 + 0.98 * ((i + 0.5) / side));
            points.push_back(axis == 0 ? 1e-8 * ((j + 1.0) * (j + 1.0)) : 0.5 + 0.05 * j);
        }
    scan_points(axis, static_cast<long>(side) * side, points.data(), out.data());
    Hash hash;
    for (const double x : out) hash.add(x);
    std::printf("  {\"name\": \"%s\", \"axis\": %d, \"side\": %d, ", name, axis, side);
    print("column", c.column.data(), static_cast<long>(c.column.size()), ", ");
    hash.print("hash", "}");
    std::printf("%s\n", after);
}

}  // namespace

int main() {
    const std::vector<Case> all = cases();
    std::printf("{\"cases\": [\n");
    for (std::size_t i = 0; i < all.size(); ++i) {
        const Case& c = all[i];
        std::memcpy(column_buffer(), c.column.data(), 8 * c.column.size());
        std::printf("  {\"name\": \"%s\",\n   ", c.name);
        print("column", c.column.data(), static_cast<long>(c.column.size()), ",\n   \"runs\": [");
        bool first = true;
        for (int model = 0; model < 3; ++model)
            for (const double until : {nan, c.until}) {
                std::printf("%s\n    {\"model\": %d, \"until\": %s, \"run\": ", first ? "" : ",", model,
                            bits(until).c_str());
                print_run(model, until);
                std::printf("}");
                first = false;
            }
        std::printf("]}%s\n", i + 1 < all.size() ? "," : "");
    }
    std::printf("],\n\"maps\": [\n");
    print_map("paper, contacts over gap", all[0], 0, 316, ",");
    print_map("paper, contacts over radius ratio", all[0], 1, 100, ",");
    print_map("viscoelastic over gap", all[5], 0, 60, ",");
    print_map("viscoelastic over radius ratio", all[5], 1, 40, "");
    std::printf("],\n");
    print_boxes();
    std::printf("}\n");
}
