// Golden values of the gas: settings and the results of the native build.
#include "../../bindings/wasm_gas.cpp"

#include "golden.hpp"

namespace {

// Indices in the registry of rules.
enum { constant, tc, by_law, soft };

struct Case {
    const char* name;
    int number;
    double fraction;
    int rule;
    double restitution, stiffness;
    bool walls;  // with gravity
    double until;
};

const Case cases[] = {
    {"thin gas", 150, 0.1, constant, 0.9, 2e3, false, 0.1},
    {"dense and soft", 150, 0.6, constant, 0.8, 300.0, false, 0.02},
    {"rule tc between walls", 120, 0.4, tc, 0.7, 1e3, true, 0.03},
    {"rule soft", 100, 0.3, soft, 0.9, 1e3, false, 0.05},
    {"rule soft between walls", 100, 0.3, soft, 0.8, 1e3, true, 0.03},
    {"without loss", 100, 0.3, constant, 1.0, 1e3, false, 0.05},
    {"inelastic collapse", 200, 0.4, constant, 0.1, 1e4, false, 0.05},
};

void write_setting(const Case& c) {
    double* const s = gas_setting(c.number);
    s[radius] = 1e-3;
    s[mass] = 1e-5;
    s[edges] = s[edges + 1] = hl::math::sqrt(c.number * hl::math::pi * 1e-6 / c.fraction);
    s[periodic] = s[periodic + 1] = c.walls ? 0.0 : 1.0;
    s[gravity + 1] = c.walls ? -9.81 : 0.0;
    s[rule] = c.rule;
    s[restitution] = c.restitution;
    s[stiffness] = c.stiffness;
    s[contact_duration] = gas_duration();
}

void print_hash(const char* name, const double* x, std::size_t n, const char* after) {
    Hash hash;
    for (std::size_t i = 0; i < n; ++i) hash.add(x[i]);
    hash.print(name, after);
}

void print_case(const Case& c, const char* after) {
    write_setting(c);
    std::printf("  {\"name\": \"%s\", \"number\": %d, ", c.name, c.number);
    print("until", &c.until, 1, ",\n   ");
    print("setting", gas().setting.data(), fields, ",\n   ");
    std::printf("\"placed\": %d, ", gas_place(5));
    gas_heat(7, 0.5);
    print_hash("start", positions(), 4 * count(), ",\n   ");
    const double depth = gas_compression(1.0, 1);
    print("compression", &depth, 1, ", ");
    std::printf("\"refusal\": %d,\n   \"worlds\": [", gas_start());
    for (int world = 0; world < 2; ++world) {
        std::printf("{\"reached\": %d, ", gas_advance(world, c.until, 1e9));
        print("observed", gas_observe(world), 16, ",\n     ");
        print_hash("state", gas_state(world), 4 * count(), ", ");
        for (const bool open : {false, true}) {
            const std::size_t logged = static_cast<std::size_t>(gas_take_log(world, open));
            std::printf("\"%s\": %zu, ", open ? "open" : "logged", logged);
            print_hash(open ? "open_rows" : "log", gas_log(), 7 * logged, open ? "}" : ", ");
        }
        std::printf("%s", world == 0 ? ",\n    " : "]}");
    }
    std::printf("%s\n", after);
}

void print_law(double phi, double epsilon, int rule_of_law, const char* after) {
    std::printf("  {\"rule\": %d, ", rule_of_law);
    const double at[] = {phi, epsilon};
    print("at", at, 2, ", ");
    print("law", law_of_error(phi, epsilon, rule_of_law, 0.0, 0.0, 1.0), 3, ", ");
    print("error", law_errors(phi, epsilon, rule_of_law, 0.0, 0.0, 1.0, 0.1), 2, ", ");
    const double last[] = {law_largest(phi, epsilon, rule_of_law, 0.0, 0.0, 1.0, 0.01),
                           law_rate(phi, 2e-3, 0.125)};
    print("last", last, 2, "}");
    std::printf("%s\n", after);
}

}  // namespace

void print_boxes() {
    std::printf("\"gases\": [\n");
    const std::size_t n = sizeof cases / sizeof *cases;
    for (std::size_t i = 0; i < n; ++i) print_case(cases[i], i + 1 < n ? "," : "");
    std::printf("],\n\"laws\": [\n");
    for (int rule_of_law = 0; rule_of_law < 3; ++rule_of_law)
        for (const double phi : {0.02, 0.3, 0.75})
            for (const double epsilon : {0.3, 0.9, 1.0})
                print_law(phi, epsilon, rule_of_law,
                          rule_of_law == 2 && phi == 0.75 && epsilon == 1.0 ? "" : ",");
    std::printf("]");
}
