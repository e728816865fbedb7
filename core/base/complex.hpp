// Complex numbers of any scalar type: two lanes, no special values.
#pragma once
#include "math.hpp"

namespace hardlimit {

template <class R>
struct Complex {
    R re, im;
};
template <class R>
HL_FN Complex<R> operator+(Complex<R> a, Complex<R> b) {
    return {a.re + b.re, a.im + b.im};
}
template <class R>
HL_FN Complex<R> operator-(Complex<R> a, Complex<R> b) {
    return {a.re - b.re, a.im - b.im};
}
template <class R>
HL_FN Complex<R> operator*(Complex<R> a, Complex<R> b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
// Re(a b)
template <class R>
HL_FN R real_product(Complex<R> a, Complex<R> b) {
    return a.re * b.re - a.im * b.im;
}
template <class R>
HL_FN Complex<R> scaled(R a, Complex<R> b) {
    return {a * b.re, a * b.im};
}
template <class R>
HL_FN Complex<R> operator/(Complex<R> a, Complex<R> b) {
    const R inverse = 1.0 / (b.re * b.re + b.im * b.im);
    return {(a.re * b.re + a.im * b.im) * inverse, (a.im * b.re - a.re * b.im) * inverse};
}
template <class R>
HL_FN R magnitude(Complex<R> a) {
    return math::sqrt<R>(a.re * a.re + a.im * a.im);
}
template <class R>
HL_FN Complex<R> choose(Mask<R> m, Complex<R> yes, Complex<R> no) {
    return {select<R>(m, yes.re, no.re), select<R>(m, yes.im, no.im)};
}

}  // namespace hardlimit
