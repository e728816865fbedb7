// Coefficient of restitution of one pair as a function of impact speed, interpolated from a few values of the law.
#pragma once
#include <vector>

#include "../../contact/law.hpp"

namespace hardlimit::boxes {

// Each octave of speeds has eight pieces with a polynomial each, fitted when a speed first falls into the piece. With
// nine nodes per piece the error of a smooth ε(v) is at rounding level, 1e-15.
template <class Law>
class RestitutionTable {
public:
    RestitutionTable(const Law& law, double mass) : law_(law), mass_(mass), pieces_(octaves * per_octave) {}

    const Law& law() const { return law_; }

    double operator()(double speed) {
        const u64 bits = bits_of<double>(speed);
        const u64 piece = (bits >> 49) - (static_cast<u64>(1023 - octaves / 2) << 3);
        if (!(speed > 0.0) || piece >= pieces_.size()) return law_.restitution(speed, mass_);
        Piece& p = pieces_[piece];
        // Coordinate from −1 to 1 on the piece, from the mantissa bits below the three that select it.
        const double x =
            real_of<double>((bits & 0x0001ffffffffffffULL) << 3 | 0x3ff0000000000000ULL) * 2.0 - 3.0;
        if (!p.known) fill(p, real_of<double>((bits >> 49) << 49));
        double sum = p.c[nodes - 1];
        for (int k = nodes - 2; k >= 0; --k) sum = sum * x + p.c[k];
        return sum;
    }

private:
    static constexpr int octaves = 200, per_octave = 8, nodes = 9;
    struct Piece {
        double c[nodes];
        bool known = false;
    };
    Law law_;
    double mass_;
    std::vector<Piece> pieces_;

    // Newton's divided differences at Chebyshev's nodes, expanded in powers of x.
    void fill(Piece& p, double low) {
        const double high = real_of<double>(bits_of<double>(low) + (1ULL << 49));
        double x[nodes], f[nodes];
        for (int k = 0; k < nodes; ++k) {
            x[k] = math::cos(math::pi * (k + 0.5) / nodes);
            f[k] = law_.restitution(0.5 * ((high + low) + (high - low) * x[k]), mass_);
        }
        for (int j = 1; j < nodes; ++j)
            for (int k = nodes - 1; k >= j; --k) f[k] = (f[k] - f[k - 1]) / (x[k] - x[k - j]);
        for (double& c : p.c) c = 0.0;
        for (int k = nodes - 1; k >= 0; --k) {
            for (int j = nodes - 1; j > 0; --j) p.c[j] = p.c[j - 1] - x[k] * p.c[j];
            p.c[0] = f[k] - x[k] * p.c[0];
        }
        p.known = true;
    }
};

}  // namespace hardlimit::boxes
