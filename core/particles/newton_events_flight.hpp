// How a body flies: cells, the next event of a body, and what happens when its time has come.
#pragma once
#include "newton_events.hpp"

namespace hardlimit::particles {

template <class Law>
Vector3 NewtonEvents<Law>::position(const Body& b, double t) const {
    const double s = t - b.from;
    Vector3 x = b.position;
    for (std::size_t a = 0; a < 3; ++a) x[a] += s * (b.velocity[a] + 0.5 * s * box_.gravity[a]);
    return x;
}

template <class Law>
Vector3 NewtonEvents<Law>::velocity(const Body& b, double t) const {
    Vector3 v = b.velocity;
    for (std::size_t a = 0; a < 3; ++a) v[a] += (t - b.from) * box_.gravity[a];
    return v;
}

template <class Law>
void NewtonEvents<Law>::make_cells() {
    const double least = 2.0 * (largest_ + widest_margin());
    std::size_t total = 1;
    for (int a = 0; a < box_.dimension; ++a) {
        const double most = math::max(1.0, box_.edge[a] / least);
        cells_[a] = static_cast<int>(math::min(most, 200.0));
        cell_edge_[a] = box_.edge[a] / cells_[a];
        total *= static_cast<std::size_t>(cells_[a]);
    }
    head_.assign(total, -1);
}

template <class Law>
std::size_t NewtonEvents<Law>::index(const std::array<int, 3>& c) const {
    return static_cast<std::size_t>((c[2] * cells_[1] + c[1]) * cells_[0] + c[0]);
}

template <class Law>
void NewtonEvents<Law>::insert(int i) {
    Body& b = body(i);
    for (int a = 0; a < box_.dimension; ++a)
        b.cell[a] = std::clamp(static_cast<int>(b.position[a] / cell_edge_[a]), 0, cells_[a] - 1);
    link(i);
}

template <class Law>
void NewtonEvents<Law>::link(int i) {
    Body& b = body(i);
    int& head = head_[index(b.cell)];
    b.previous = -1;
    b.next = head;
    if (head >= 0) body(head).previous = i;
    head = i;
}

template <class Law>
void NewtonEvents<Law>::unlink(int i) {
    Body& b = body(i);
    if (b.next >= 0) body(b.next).previous = b.previous;
    (b.previous >= 0 ? body(b.previous).next : head_[index(b.cell)]) = b.next;
}

template <class Law>
template <class F>
void NewtonEvents<Law>::around(const std::array<int, 3>& cell, const F& f) const {
    std::array<int, 3> from{}, to{};
    for (int a = 0; a < box_.dimension; ++a) from[a] = -1, to[a] = 1;
    for (int dz = from[2]; dz <= to[2]; ++dz)
        for (int dy = from[1]; dy <= to[1]; ++dy)
            for (int dx = from[0]; dx <= to[0]; ++dx) {
                std::array<int, 3> c{cell[0] + dx, cell[1] + dy, cell[2] + dz};
                Vector3 shift{};
                bool inside = true;
                for (int a = 0; a < box_.dimension; ++a) {
                    if (c[a] >= 0 && c[a] < cells_[a]) continue;
                    inside = inside && box_.periodic[a];
                    shift[a] = c[a] < 0 ? -box_.edge[a] : box_.edge[a];
                    c[a] += c[a] < 0 ? cells_[a] : -cells_[a];
                }
                if (!inside) continue;
                for (int j = head_[index(c)]; j >= 0; j = body(j).next) f(j, shift);
            }
}

template <class Law>
void NewtonEvents<Law>::predict(int i) {
    Body& b = body(i);
    b.when = math::infinity;
    b.what = What::none;
    const Vector3 x = position(b, now_), v = velocity(b, now_);
    predict_meeting(b, i, x, v);
    for (int a = 0; a < box_.dimension; ++a) {
        if (!box_.periodic[a] && b.group < 0) predict_wall(b, a, x[a], v[a]);
        predict_crossing(b, a, x[a], v[a]);
    }
    queue_.push({b.when, i, ++b.event});
}

// The first body that b comes near, both on their parabolas: those of bodies that are not busy touch there.
template <class Law>
void NewtonEvents<Law>::predict_meeting(Body& b, int i, const Vector3& x, const Vector3& v) {
    around(b.cell, [&](int j, const Vector3& shift) {
        const Body& o = body(j);
        if (j == i || (b.group >= 0 && b.group == o.group)) return;
        const Vector3 xo = position(o, now_), vo = velocity(o, now_);
        Vector3 r, u;
        for (std::size_t a = 0; a < 3; ++a) {
            r[a] = (xo[a] + shift[a]) - x[a];
            u[a] = vo[a] - v[a];
        }
        const double reach = (b.radius + b.margin) + (o.radius + o.margin);
        const double closing = -dot(r, u), beyond = dot(r, r) - reach * reach;
        if (!(closing > 0.0) && !(beyond < 0.0 && (b.group >= 0 || o.group >= 0))) return;
        double t = now_;
        if (beyond > 0.0) {
            const double square = closing * closing - dot(u, u) * beyond;
            if (square < 0.0) return;
            t = now_ + beyond / (closing + math::sqrt(square));
        }
        if (t >= b.when || t > b.end || t > o.end) return;
        b.when = t;
        b.what = What::meets;
        b.partner = j;
        b.partner_version = o.version;
    });
}

template <class Law>
void NewtonEvents<Law>::predict_wall(Body& b, int a, double x, double v) {
    for (int far = 0; far < 2; ++far) {
        const double gap = (far ? box_.edge[a] - x : x) - b.radius;
        const double rate = far ? v : -v, towards = far ? box_.gravity[a] : -box_.gravity[a];
        double t = math::infinity;
        const double square = rate * rate + 2.0 * towards * math::max(gap, 0.0);
        if (gap <= 0.0 && rate > 0.0)
            t = 0.0;
        else if (gap <= 0.0)
            t = towards > 0.0 ? -2.0 * rate / towards : math::infinity;
        else if (square >= 0.0 && rate > 0.0)
            t = 2.0 * gap / (rate + math::sqrt(square));
        else if (square >= 0.0 && towards > 0.0)
            t = (math::sqrt(square) - rate) / towards;
        if (now_ + t >= b.when) continue;
        b.when = now_ + t;
        b.what = What::wall;
        b.partner = 2 * a + far;
    }
}

// When the parabola leaves the cell along axis a.
template <class Law>
void NewtonEvents<Law>::predict_crossing(Body& b, int a, double x, double v) {
    const double g = box_.gravity[a];
    for (int up = 0; up < 2; ++up) {
        if (!box_.periodic[a] && (up ? b.cell[a] == cells_[a] - 1 : b.cell[a] == 0)) continue;
        const double border = cell_edge_[a] * (b.cell[a] + up);
        const double gap = math::max(up ? border - x : x - border, 0.0);
        const double rate = up ? v : -v, towards = up ? g : -g;
        const double square = rate * rate + 2.0 * towards * gap;
        double t = math::infinity;
        if (square >= 0.0 && rate > 0.0)
            t = 2.0 * gap / (rate + math::sqrt(square));
        else if (square >= 0.0 && towards > 0.0)
            t = (math::sqrt(square) - rate) / towards;
        if (now_ + t >= b.when) continue;
        b.when = now_ + t;
        b.what = What::crosses;
        b.partner = 2 * a + up;
    }
}

template <class Law>
void NewtonEvents<Law>::happen(int i) {
    Body& b = body(i);
    if (b.what == What::crosses) return cross(i);
    if (b.what == What::wall) return meet(i, -1, b.partner);
    const Body& o = body(b.partner);
    if (o.version != b.partner_version) return predict(i);
    const int j = b.partner;
    if (b.group < 0 && o.group < 0) return meet(i, j, 0);
    conflict(i, j);
}

template <class Law>
void NewtonEvents<Law>::cross(int i) {
    Body& b = body(i);
    const int a = b.partner / 2, up = b.partner % 2;
    unlink(i);
    b.cell[a] += up ? 1 : -1;
    if (b.cell[a] < 0 || b.cell[a] >= cells_[a]) {
        b.cell[a] += up ? -cells_[a] : cells_[a];
        b.position[a] += up ? -box_.edge[a] : box_.edge[a];
        b.turns[a] += up ? 1 : -1;
    }
    link(i);
    predict(i);
}

}  // namespace hardlimit::particles
