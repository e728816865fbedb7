// Construction of the engine, new or from a checkpoint, and the order of the particles in memory.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <int d, bool mixed>
HardSpheres<d, mixed>::HardSpheres(const System& s, const RuleChoice& rule, bool keep_log,
                                   const hardlimit_abi::TouchKernels& kernels, Stop& stop, Growth growth)
    : box_(s.box), growth_(growth), keep_log_(keep_log) {
    smallest_radius_ = *std::min_element(s.radius, s.radius + s.n);
    largest_radius_ = *std::max_element(s.radius, s.radius + s.n);
    mass_ = s.mass[0];
    set_rule(rule);
    set_motion(kernels);
    make_cells(s.n);
    columns_ = cells_.columns();
    sort_in(s);
    fill_cells();
    next_sort_ = collisions_between_sorts * s.n;
    if (takes_time_) last_contacts_.assign(s.n, {});
    Sum total;
    for (std::size_t i = 0; i < s.n; ++i) total.add(s.mass[i]);
    accumulators_.mass = total.value();
    std::copy_n(box_.gravity, d, accumulators_.gravity);
    accumulators_.gradient = box_.gradient, accumulators_.shear_rate = box_.shear_rate;
    refresh_accumulators();
    predict_all(stop);
    rebuild_queue();
}

template <int d, bool mixed>
HardSpheres<d, mixed>::HardSpheres(Reader& saved, const hardlimit_abi::TouchKernels& kernels) {
    archive(saved);
    if (saved.failed()) return;
    set_motion(kernels);
    make_cells(particles_.size());
    if (box_.is_sheared()) cells_.set_columns(columns_);
    fill_cells();
    rebuild_queue();
}

template <int d, bool mixed>
std::vector<char> HardSpheres<d, mixed>::save() const {
    Writer w("hard_spheres");
    w(Kind{d, mixed});
    const_cast<HardSpheres*>(this)->archive(w);  // a Writer changes nothing
    return w.finish();
}

template <int d, bool mixed>
template <class Archive>
void HardSpheres<d, mixed>::archive(Archive& a) {
    a(box_), a(choice_), a(growth_), a(keep_log_), a(mass_), a(smallest_radius_), a(largest_radius_);
    a(particles_), a(pending_), a(image_flags_), a(original_index_), a(masses_), a(rescans_), a(fastest_);
    a(accumulators_), a(until_refresh_), a(now_), a(paused_), a(outcome_), a(log_);
    a(early_end_.time), a(early_end_.particles), a(early_end_.wall);
    a(last_contacts_), a(soft_contacts_), a(soft_third_body_), a(deepest_), a(columns_);
    collapse_.archive(a);
    set_rule(choice_);
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::set_rule(const RuleChoice& choice) {
    choice_ = choice;
    rule_ = make_rule(choice, {mass_, largest_radius_, !mixed});
    takes_time_ = rule_ && rule_->takes_time();
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::set_motion(const hardlimit_abi::TouchKernels& kernels) {
    motion_ = growth_.rate != 0.0 ? Motion::growing : box_.falls() ? Motion::falling : Motion::straight;
    touch_ = kernels.of[d - 2][static_cast<int>(motion_)];
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::make_cells(std::size_t n) {
    cells_ = Cells<d>(box_, n, 2.0 * smallest_radius_, 2.0 * largest_radius_);
    prepare_query();
    prefetches_ = n > most_in_caches;
}

// Stores the particles sorted by cell, so that neighbours in space are neighbours in memory.
template <int d, bool mixed>
void HardSpheres<d, mixed>::sort_in(const System& s) {
    const u32 n = static_cast<u32>(s.n);
    std::vector<u32> cell(n);
    // Returns by how many edges the position has been moved back along the first axis.
    const auto position_of = [&](u32 i, double (&x)[d]) {
        for (int k = 0; k < d; ++k) x[k] = s.position[std::size_t{i} * d + static_cast<std::size_t>(k)];
        const int turns = box_.is_sheared() ? box_.turns(cells_.along(x, 0.0), 0) : 0;
        if (turns != 0) x[0] -= turns * box_.edge[0];
        return turns;
    };
    for (u32 i = 0; i < n; ++i) {
        double x[d];
        position_of(i, x);
        const int own = mixed ? cells_.level_for(2.0 * s.radius[i]) : 0;
        cell[i] = cells_.number(own, cells_.place_of(own, x));
    }
    const std::vector<u32> order = order_by_cell(cell);
    particles_.resize(n);
    pending_.resize(n);
    image_flags_.resize(n, {});
    original_index_.assign(order.begin(), order.end());
    if constexpr (mixed) {
        masses_.resize(n);
        if (cells_.levels() > 1) rescans_.assign(n, math::infinity);
    }
    for (u32 i = 0; i < n; ++i) {
        const u32 from = order[i], later = order[std::min(i + 24, n - 1)];
        prefetch(&s.position[std::size_t{later} * d]);
        prefetch(&s.velocity[std::size_t{later} * d]);
        Particle<d>& p = particles_[i];
        image_flags_[i][0] = position_of(from, p.position);
        for (int k = 0; k < d; ++k)
            p.velocity[k] = s.velocity[std::size_t{from} * d + static_cast<std::size_t>(k)];
        p.time = 0.0;
        p.radius = mixed ? s.radius[from] : collision_count;
        if constexpr (mixed) masses_[i] = s.mass[from];
        pending_[i].cell = cell[from] & (most_cells - 1);
        fastest_ = math::max(fastest_, frame_speed(p.velocity));
    }
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::fill_cells() {
    cells_.clear();
    for (u32 i = 0; i < size32(); ++i) {
        cells_.insert(pending_[i].cell, i);
        if constexpr (mixed) cells_.note(level(i), 2.0 * radius(i));
    }
}

// Tilts the columns of cells of a sheared box back, against the flow. All particles get new cells, and all events are
// predicted again.
template <int d, bool mixed>
void HardSpheres<d, mixed>::tilt_cells() {
    cells_.tilt_back();
    columns_ = cells_.columns();
    for (u32 i = 0; i < size32(); ++i) pending_[i].cell = fold_into_column(i) & (most_cells - 1);
    fill_cells();
    Stop never;
    predict_all(never);
    rebuild_queue();
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::predict_all(Stop& stop) {
    for (u32 i = 0; i < size32() && !stop(); ++i) predict_unscheduled(i, excluded_partner(i));
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::rebuild_queue() {
    calendar_.rebuild(
        size32(), [this](u32 id) { return event_time(id); }, [this](u32 id) { return original_index_[id]; });
}

// Sets records[i] = records[from[i]] in place, one cycle of the permutation after the other.
template <class T>
void permute(Records<T>& records, const std::vector<u32>& from) {
    std::vector<bool> done(from.size());
    for (u32 start = 0; start < from.size(); ++start) {
        if (done[start] || from[start] == start) continue;
        const T first = records[start];
        u32 at = start;
        for (; from[at] != start; at = from[at]) {
            records[at] = records[from[at]];
            done[at] = true;
        }
        records[at] = first;
        done[at] = true;
    }
}

// Sorts the particles by cell again, since neighbours in memory move apart. This affects only the computing time.
template <int d, bool mixed>
void HardSpheres<d, mixed>::sort_along_cells() {
    next_sort_ = accumulators_.collisions() + collisions_between_sorts * particles_.size();
    const u32 n = size32();
    std::vector<u32> cell(n);
    for (u32 i = 0; i < n; ++i) cell[i] = pending_[i].cell;
    const std::vector<u32> from = order_by_cell(cell);
    permute(particles_, from);
    permute(pending_, from);
    permute(image_flags_, from);
    permute(original_index_, from);
    if (!masses_.empty()) permute(masses_, from);
    if (!rescans_.empty()) permute(rescans_, from);
    if (!last_contacts_.empty()) permute(last_contacts_, from);
    std::vector<u32> now_at(n);
    for (u32 i = 0; i < n; ++i) now_at[from[i]] = i;
    const auto follow = [&](u32& partner) {
        if (partner != no_particle) partner = now_at[partner];
    };
    for (PendingEvents& e : pending_) follow(e.partner);
    for (LastContact& c : last_contacts_) follow(c.partner);
    fill_cells();
    rebuild_queue();
}

}  // namespace hardlimit::boxes
