// Compares the exact and the general solver over random columns of two balls; every difference must be explained.
//
//   g++ -std=c++20 -O3 -ffp-contract=off -fno-math-errno -fno-trapping-math -Icore -Itests/fuzz
//       tools/exact_against_general.cpp -o exact_against_general
//   ./exact_against_general 10000000 columns.txt
//
// Each column is drawn from its number as seed. The file gets one line for each block of 10000 columns; a restarted
// program continues after the last block. Unexplained columns are written with all their parameters and make the exit
// status 1. tests/fuzz/draw.hpp has the ranges of the columns, tests/fuzz/agreement.hpp the accepted explanations. A
// column that the general solver has not solved within 1000 steps, or 50000 for one column in a thousand, counts as
// unresolved.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "agreement.hpp"

namespace {

using namespace hardlimit;

constexpr long block = 10'000;
constexpr double most_damping = 20.0;  // in units of critical damping: ε ≥ 6e-4

struct Counts {
    long columns = 0, verdict[fuzz::verdicts] = {};
    double worst = 0.0, backward_error = 0.0;  // largest difference called equal; largest backward error

    void add(const Counts& o) {
        columns += o.columns;
        for (int i = 0; i < fuzz::verdicts; ++i) verdict[i] += o.verdict[i];
        worst = math::max(worst, o.worst);
        backward_error = math::max(backward_error, o.backward_error);
    }
    std::string line() const {
        std::ostringstream out;
        out << columns;
        for (const long n : verdict) out << ' ' << n;
        out << ' ' << worst << ' ' << backward_error;
        return out.str();
    }
};

// Sums over earlier runs; lines of single columns begin with a word and are skipped.
Counts read(const char* path) {
    Counts sum;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::istringstream in(line);
        Counts one;
        in >> one.columns;
        for (long& n : one.verdict) in >> n;
        in >> one.worst >> one.backward_error;
        if (in) sum.add(one);
    }
    return sum;
}

void describe(long number, const fuzz::LinearColumn& c, const fuzz::Agreement& a, std::ofstream& file) {
    char text[1024];
    const auto put = [&](const char* name, const fuzz::Sequence& q) {
        std::snprintf(text, sizeof text, " %s %s n=%d v'_r=%.17g separation=%.17g t_f=%.17g floor=%.17g\n",
                      name, outcome_records[static_cast<int>(q.outcome)].name, q.n_contacts,
                      q.relative_velocity, q.separation_velocity, q.t_end, q.t_floor_end);
        file << text;
    };
    std::snprintf(text, sizeof text, "unexplained %ld g=%.17g m=%.17g,%.17g k=%.17g,%.17g gamma=%.17g,%.17g ",
                  number, c.gravity, c.mass[0], c.mass[1], c.contacts[0].stiffness, c.contacts[1].stiffness,
                  c.contacts[0].damping, c.contacts[1].damping);
    file << text;
    std::snprintf(text, sizeof text, "gaps=%.17g,%.17g v=%.17g,%.17g difference=%g\n", c.gaps[0], c.gaps[1],
                  c.velocity[0], c.velocity[1], a.difference);
    file << text;
    put("exact  ", a.exact);
    put("general", a.general);
    file.flush();
}

fuzz::LinearColumn numbered(long number) {
    fuzz::Draw<fuzz::Random> draw{fuzz::Random(static_cast<std::uint64_t>(number))};
    fuzz::LinearColumn c = fuzz::draw_column<contact::LinearDashpot>(draw, 2, true);
    fuzz::limit_damping(c, most_damping);
    return c;
}

Counts compare_block(long first, std::ofstream& file) {
    Counts counts;
    for (long number = first; number < first + block; ++number) {
        const fuzz::LinearColumn c = numbered(number);
        const fuzz::Agreement a = fuzz::compare(c, number % 1000 == 0 ? 50'000 : 1'000,
                                                fuzz::Random(~static_cast<std::uint64_t>(number)));
        ++counts.columns;
        ++counts.verdict[static_cast<int>(a.verdict)];
        if (a.verdict == fuzz::Verdict::equal) counts.worst = math::max(counts.worst, a.difference);
        counts.backward_error = math::max(counts.backward_error, a.backward_error);
        if (a.verdict == fuzz::Verdict::unexplained) describe(number, c, a, file);
    }
    return counts;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fputs("usage: exact_against_general COLUMNS FILE\n", stderr);
        return 2;
    }
    const long wanted = std::atol(argv[1]);
    Counts sum = read(argv[2]);
    std::ofstream file(argv[2], std::ios::app);
    while (sum.columns < wanted) {
        const Counts counts = compare_block(sum.columns, file);
        file << counts.line() << std::endl;
        sum.add(counts);
    }
    constexpr const char* names[fuzz::verdicts] = {"equal", "truncated", "conditioned", "tie",
                                                   "flat",  "invalid",   "unresolved",  "unexplained"};
    std::printf("columns %ld\n", sum.columns);
    for (int i = 0; i < fuzz::verdicts; ++i) std::printf("%s %ld\n", names[i], sum.verdict[i]);
    std::printf("largest difference called equal %.1e, largest backward error %.1e\n", sum.worst,
                sum.backward_error);
    return sum.verdict[7] > 0;
}
