// How a run begins, and what is kept exact on the way.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <int d, Motion motion, bool mixed>
HardSpheres<d, motion, mixed>::HardSpheres(const Setting& s, const RuleChoice& rule, bool keep_log,
                                           Stop& stop, Growth growth)
    : growth_(growth), keep_log_(keep_log), touch_(kernels_of(*s.kernels)) {
    for (int k = 0; k < d; ++k) {
        box_.edge[k] = s.edge[k];
        box_.periodic[k] = s.periodic[k];
        box_.gravity[k] = s.gravity[k];
    }
    smallest_radius_ = *std::min_element(s.radius, s.radius + s.n);
    largest_radius_ = *std::max_element(s.radius, s.radius + s.n);
    mass_ = s.mass[0];
    make_rule(rule);
    lay_cells(s.n);
    take(s);
    put_into_cells();
    next_sort_ = collisions_between_sorts * static_cast<i64>(s.n);
    if (rule.soft) softs_.assign(s.n, {-math::infinity, no_particle});
    refresh_tally();
    predict_all(stop);
    restart_calendar();
}

template <int d, Motion motion, bool mixed>
HardSpheres<d, motion, mixed>::HardSpheres(Reader& saved, const hardlimit_abi::TouchKernels& kernels)
    : touch_(kernels_of(kernels)) {
    archive(saved);
    if (saved.failed()) return;
    lay_cells(particles_.size());
    put_into_cells();
    restart_calendar();
}

template <int d, Motion motion, bool mixed>
std::vector<char> HardSpheres<d, motion, mixed>::save() const {
    Writer w;
    w(Kind{d, motion, mixed});
    const_cast<HardSpheres*>(this)->archive(w);  // which does not change what it writes
    return w.finish();
}

template <int d, Motion motion, bool mixed>
template <class Archive>
void HardSpheres<d, motion, mixed>::archive(Archive& a) {
    RuleChoice choice = rule_.choice();
    a(box_), a(choice), a(growth_), a(keep_log_), a(mass_), a(smallest_radius_), a(largest_radius_);
    a(particles_), a(pending_), a(periods_), a(names_), a(masses_), a(rescans_), a(fastest_);
    a(tally_), a(until_refresh_), a(now_), a(outcome_), a(early_end_);
    a(log_.time), a(log_.first), a(log_.second), a(log_.impact_speed), a(log_.separation_speed);
    a(softs_), a(soft_contacts_), a(soft_third_body_), a(deepest_);
    watch_.archive(a);
    make_rule(choice);
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::make_rule(const RuleChoice& choice) {
    std::vector<PairGeometry> alike;
    if (!mixed) alike = {{0.5 * mass_, 0.5 * largest_radius_}, {mass_, largest_radius_}};
    rule_ = Rule(choice, alike);
    if (choice.soft)
        soft_ = soft_rule(choice, {0.5 * mass_, 0.5 * largest_radius_}, 2.0 * largest_radius_, !mixed);
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::lay_cells(std::size_t n) {
    cells_ = Cells<d>(box_, n, 2.0 * smallest_radius_, 2.0 * largest_radius_);
    prepare_query();
    fetches_ = n > most_in_caches;
}

// Particles in the order of their cells: neighbours in space are neighbours in memory.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::take(const Setting& s) {
    const u32 n = static_cast<u32>(s.n);
    std::vector<u32> cell(n), order(n);
    const auto position_of = [&](u32 i, double (&x)[d]) {
        for (int k = 0; k < d; ++k) x[k] = s.position[std::size_t{i} * d + static_cast<std::size_t>(k)];
    };
    for (u32 i = 0; i < n; ++i) {
        double x[d];
        position_of(i, x);
        const int own = mixed ? cells_.level_for(2.0 * s.radius[i]) : 0;
        cell[i] = cells_.number(own, cells_.place_of(own, x));
        order[i] = i;
    }
    std::sort(order.begin(), order.end(),
              [&](u32 a, u32 b) { return cell[a] != cell[b] ? cell[a] < cell[b] : a < b; });
    particles_.resize(n);
    pending_.resize(n);
    periods_.resize(n, {});
    names_.assign(order.begin(), order.end());
    if constexpr (mixed) {
        masses_.resize(n);
        if (cells_.levels() > 1) rescans_.assign(n, math::infinity);
    }
    for (u32 i = 0; i < n; ++i) {
        const u32 from = order[i];
        Particle<d>& p = particles_[i];
        position_of(from, p.position);
        for (int k = 0; k < d; ++k)
            p.velocity[k] = s.velocity[std::size_t{from} * d + static_cast<std::size_t>(k)];
        p.time = 0.0;
        p.radius = mixed ? s.radius[from] : collision_count;
        if constexpr (mixed) masses_[i] = s.mass[from];
        pending_[i].cell = cell[from] & (most_cells - 1);
        fastest_ = math::max(fastest_, frame_speed(p.velocity));
    }
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::put_into_cells() {
    cells_.clear();
    for (u32 i = 0; i < size32(); ++i) cells_.insert(pending_[i].cell, i);
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::predict_all(Stop& stop) {
    for (u32 i = 0; i < size32() && !stop(); ++i) predict_unscheduled(i, no_particle);
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::restart_calendar() {
    calendar_.rebuild(
        size32(), [this](u32 id) { return event_time(id); }, [this](u32 id) { return names_[id]; });
}

// Energy and momentum anew: what accumulates loses its digits while a gas cools by many orders of magnitude.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::refresh_tally() {
    until_refresh_ = std::max<i64>(8192, 32 * static_cast<i64>(particles_.size()));
    std::vector<u32> place(size32());
    for (u32 i = 0; i < size32(); ++i) place[names_[i]] = i;
    Sum mass_sum, kinetic, momentum[d];
    for (const u32 i : place) {
        const Particle<d>& p = particles_[i];
        double square = 0.0;
        for (int k = 0; k < d; ++k) {
            const double v = velocity_after<motion>(p, k, now_ - p.time, box_);
            square += v * v;
            momentum[k].add(mass(i) * v);
        }
        kinetic.add(0.5 * mass(i) * square);
        mass_sum.add(mass(i));
    }
    tally_.mass = mass_sum.value();
    for (int k = 0; k < d; ++k) tally_.gravity[k] = box_.gravity[k];
    tally_.advance(now_);
    tally_.kinetic = kinetic.value();
    for (int k = 0; k < d; ++k) tally_.momentum[k] = momentum[k].value();
}

template <int d, Motion motion, bool mixed>
Observation HardSpheres<d, motion, mixed>::observe() const {
    Observation o{};
    std::vector<u32> place(size32());
    for (u32 i = 0; i < size32(); ++i) place[names_[i]] = i;
    Sum kinetic, potential, momentum[d];
    for (const u32 i : place) {
        const Particle<d>& p = particles_[i];
        const double after = now_ - p.time, m = mass(i);
        double square = 0.0;
        for (int k = 0; k < d; ++k) {
            const double v = velocity_after<motion>(p, k, after, box_);
            const double x = position_after<motion>(p, k, after, box_) +
                             periods_[i][static_cast<std::size_t>(k)] * box_.edge[k];
            square += v * v;
            momentum[k].add(m * v);
            potential.add(-m * box_.gravity[k] * x);
        }
        kinetic.add(0.5 * m * square);
    }
    o.kinetic_energy = kinetic.value();
    o.potential_energy = potential.value();
    for (int k = 0; k < d; ++k) o.momentum[k] = momentum[k].value();
    o.dissipated_energy = tally_.dissipated.value();
    o.virial = tally_.virial.value();
    o.kinetic_integral = tally_.integral_until(now_);
    return o;
}

template <int d, Motion motion, bool mixed>
std::size_t HardSpheres<d, motion, mixed>::bytes() const {
    const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
    return sizeof(*this) + of(particles_) + of(pending_) + of(periods_) + of(names_) + of(masses_) +
           of(rescans_) + of(softs_) + of(candidates_) + cells_.bytes() + calendar_.bytes();
}

}  // namespace hardlimit::boxes
