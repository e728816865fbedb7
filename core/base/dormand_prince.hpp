// One step of the explicit Runge-Kutta method of Dormand and Prince of order 8, with error estimators of
// orders 5 and 3, for an autonomous system dy/dτ = f(y):
//   k_i = f(y + h Σ_{j<i} a_ij k_j),  y(h) = y + h Σ b_i k_i,
//   error = |h| e5²/√((e5² + 0.01 e3²) n),  e5, e3 = norms of Σ e_i k_i in units of the caller's scale.
// Source: Hairer, Nørsett & Wanner, Solving Ordinary Differential Equations I (2nd ed., 1993), Sec. II.5,
// II.10. The quotient behaves as h^8, so one exponent 1/8 steers the step.
//
// There is no interpolant. A state inside a step is the end of a shorter step from the same start: it has the
// full order, at the price of the twelve stages, and nothing but the start needs to be remembered.
#pragma once
#include <cstring>

#include "math.hpp"

namespace hardlimit {

struct DormandPrince {
    static constexpr int order = 8;
    static constexpr int stages = 12;

    static constexpr double a[stages][stages] = {
        {0.0},
        {5.26001519587677318785587544488e-2},
        {1.97250569845378994544595329183e-2, 5.91751709536136983633785987549e-2},
        {2.95875854768068491816892993775e-2, 0.0, 8.87627564304205475450678981324e-2},
        {2.41365134159266685502369798665e-1, 0.0, -8.84549479328286085344864962717e-1,
         9.24834003261792003115737966543e-1},
        {3.7037037037037037037037037037e-2, 0.0, 0.0, 1.70828608729473871279604482173e-1,
         1.25467687566822425016691814123e-1},
        {3.7109375e-2, 0.0, 0.0, 1.70252211019544039314978060272e-1, 6.02165389804559606850219397283e-2,
         -1.7578125e-2},
        {3.70920001185047927108779319836e-2, 0.0, 0.0, 1.70383925712239993810214054705e-1,
         1.07262030446373284651809199168e-1, -1.53194377486244017527936158236e-2,
         8.27378916381402288758473766002e-3},
        {6.24110958716075717114429577812e-1, 0.0, 0.0, -3.36089262944694129406857109825,
         -8.68219346841726006818189891453e-1, 2.75920996994467083049415600797e1,
         2.01540675504778934086186788979e1, -4.34898841810699588477366255144e1},
        {4.77662536438264365890433908527e-1, 0.0, 0.0, -2.48811461997166764192642586468,
         -5.90290826836842996371446475743e-1, 2.12300514481811942347288949897e1,
         1.52792336328824235832596922938e1, -3.32882109689848629194453265587e1,
         -2.03312017085086261358222928593e-2},
        {-9.3714243008598732571704021658e-1, 0.0, 0.0, 5.18637242884406370830023853209,
         1.09143734899672957818500254654, -8.14978701074692612513997267357,
         -1.85200656599969598641566180701e1, 2.27394870993505042818970056734e1,
         2.49360555267965238987089396762, -3.0467644718982195003823669022},
        {2.27331014751653820792359768449, 0.0, 0.0, -1.05344954667372501984066689879e1,
         -2.00087205822486249909675718444, -1.79589318631187989172765950534e1,
         2.79488845294199600508499808837e1, -2.85899827713502369474065508674,
         -8.87285693353062954433549289258, 1.23605671757943030647266201528e1,
         6.43392746015763530355970484046e-1},
    };
    static constexpr double b[stages] = {5.42937341165687622380535766363e-2,
                                         0.0,
                                         0.0,
                                         0.0,
                                         0.0,
                                         4.45031289275240888144113950566,
                                         1.89151789931450038304281599044,
                                         -5.8012039600105847814672114227,
                                         3.1116436695781989440891606237e-1,
                                         -1.52160949662516078556178806805e-1,
                                         2.01365400804030348374776537501e-1,
                                         4.47106157277725905176885569043e-2};
    static constexpr double e5[stages] = {0.1312004499419488073250102996e-1,
                                          0.0,
                                          0.0,
                                          0.0,
                                          0.0,
                                          -0.1225156446376204440720569753e+1,
                                          -0.4957589496572501915214079952,
                                          0.1664377182454986536961530415e+1,
                                          -0.3503288487499736816886487290,
                                          0.3341791187130174790297318841,
                                          0.8192320648511571246570742613e-1,
                                          -0.2235530786388629525884427845e-1};
    static constexpr double third[3] = {// e3 = b except at stages 1, 9 and 12
                                        0.244094488188976377952755905512, 0.733846688281611857341361741547,
                                        0.220588235294117647058823529412e-1};

    // out = y(h) from y and k[0..n) = f(y). `k` [stages * n] receives the stages. `out` must not alias `y`. Components
    // from `needed` on are pure integrals: f does not read them, and they are not computed within the step.
    template <class Rhs>
    HL_FN static void step(const Rhs& f, const double* y, double h, int n, double* k, double* out,
                           int needed) {
        run_stage<1>(f, y, h, n, k, out, needed);
        combine<stages>(y, h, n, k, out, n);
    }
    template <class Rhs>
    HL_FN static void step(const Rhs& f, const double* y, double h, int n, double* k, double* out) {
        step(f, y, h, n, k, out, n);
    }

    // Error of the step just taken in units of `scale` [n]; below 1 it is acceptable.
    HL_FN static double error(const double* k, double h, int n, const double* scale) {
        return error(k, h, n, scale, n, n);
    }
    // The same from the first `used` of n components, as a mean over `number` components.
    HL_FN static double error(const double* k, double h, int n, const double* scale, int used, int number) {
        double fifth = 0.0, third_order = 0.0;
        const auto add = [&](double high, double low) {
            fifth += high * high;
            third_order += low * low;
        };
        int c = 0;
        for (; c + 2 <= used; c += 2) {
            const Two unit = load<Two>(scale + c), high = high_error<Two>(k + c, n) / unit,
                      low = low_error<Two>(k + c, n) / unit;
            add(high[0], low[0]);
            add(high[1], low[1]);
        }
        if (c < used) add(high_error<double>(k + c, n) / scale[c], low_error<double>(k + c, n) / scale[c]);
        if (fifth == 0.0 && third_order == 0.0) return 0.0;
        return math::abs(h) * fifth / math::sqrt((fifth + 0.01 * third_order) * number);
    }

    // Factor for the next step size. A result that is not finite asks for a much shorter step.
    HL_FN static double growth(double error) {
        if (!math::is_finite(error)) return 0.1;
        if (error < 1e-8) return 6.0;
        const double root = math::sqrt(math::sqrt(math::sqrt(error)));
        return math::clamp(0.9 / root, 0.2, 6.0);
    }

private:
    using Two = Vector<2>::Real;  // what every processor has registers for

    template <class Real>
    HL_FN static Real load(const double* from) {
        Real x;
        std::memcpy(&x, from, sizeof x);
        return x;
    }

    template <int i, class Rhs>
    HL_FN static void run_stage(const Rhs& f, const double* y, double h, int n, double* k, double* out,
                                int needed) {
        if constexpr (i < stages) {
            combine<i>(y, h, n, k, out, needed);
            f(out, k + i * n);
            run_stage<i + 1>(f, y, h, n, k, out, needed);
        }
    }

    // out = y + h Σ a_ij k_j for a stage i, with b_j for i = `stages`, of the first `used` of n components. Several are
    // computed at a time, whose sums stay in registers.
    template <int i>
    HL_FN static void combine(const double* y, double h, int n, const double* k, double* out, int used) {
        int c = 0;
        for (; c + 8 <= used; c += 8) combine_some<i, 4, Two>(y, h, n, k, out, c);
        for (; c + 2 <= used; c += 2) combine_some<i, 1, Two>(y, h, n, k, out, c);
        if (c < used) combine_some<i, 1, double>(y, h, n, k, out, c);
    }

    template <int i, int width, class Real>
    HL_FN_INLINE static void combine_some(const double* y, double h, int n, const double* k, double* out,
                                          int c) {
        constexpr int step = Lanes<Real>::count;
        constexpr const double (&weight)[stages] = i < stages ? a[i < stages ? i : 0] : b;
        Real sum[width];
        HL_UNROLL for (int w = 0; w < width; ++w) sum[w] = weight[0] * load<Real>(k + c + step * w);
        HL_UNROLL for (int j = 1; j < i; ++j) {
            if (weight[j] == 0.0) continue;
            HL_UNROLL for (int w = 0; w < width; ++w) sum[w] +=
                weight[j] * load<Real>(k + j * n + c + step * w);
        }
        HL_UNROLL for (int w = 0; w < width; ++w) {
            const Real to = load<Real>(y + c + step * w) + h * sum[w];
            std::memcpy(out + c + step * w, &to, sizeof to);
        }
    }

    // Of one component, or of several that are side by side.
    template <class Real>
    HL_FN static Real high_error(const double* k, int n) {
        Real sum = e5[0] * load<Real>(k);
        HL_UNROLL for (int i = 1; i < stages; ++i) if (e5[i] != 0.0) sum += e5[i] * load<Real>(k + i * n);
        return sum;
    }
    template <class Real>
    HL_FN static Real low_error(const double* k, int n) {
        Real sum = b[0] * load<Real>(k);
        HL_UNROLL for (int i = 1; i < stages; ++i) if (b[i] != 0.0) sum += b[i] * load<Real>(k + i * n);
        return sum - (third[0] * load<Real>(k) + third[1] * load<Real>(k + 8 * n) +
                      third[2] * load<Real>(k + 11 * n));
    }
};

}  // namespace hardlimit
