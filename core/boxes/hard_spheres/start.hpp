// Construction of the engine, and what renews all events or the order of the particles in memory.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <int d, bool mixed>
HardSpheres<d, mixed>::HardSpheres(spheres::Setting&& setting, const hardlimit_abi::TouchKernels& kernels)
    : setting_(std::move(setting)),
      particles_(setting_),
      totals_(particles_),
      cells_(particles_, totals_),
      predictor_(particles_, cells_, last_contacts_, kernels),
      schedule_(particles_, cells_),
      log_(particles_.original_index, setting_.keeps_log),
      collisions_(particles_, totals_, cells_, last_contacts_, collapse_, log_),
      growing_(particles_, totals_) {}

template <int d, bool mixed>
HardSpheres<d, mixed>::HardSpheres(const System& s, const RuleChoice& rule, bool keep_log,
                                   const hardlimit_abi::TouchKernels& kernels, Stop& stop,
                                   spheres::Growth growth)
    : HardSpheres(spheres::Setting(s, rule, keep_log, growth), kernels) {
    cells_.begin(s);
    next_sort_ = collisions_between_sorts * s.n;
    if (collisions_.take_time()) last_contacts_.begin(s.n);
    totals_.begin(s);
    predict_all(stop);
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::predict_all(Stop& stop) {
    for (u32 i = 0; i < particles_.size() && !stop(); ++i)
        predictor_.predict(i, last_contacts_.excluded_partner(i));
    schedule_.rebuild();
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::tilt_cells() {
    cells_.tilt_back();
    Stop never;
    predict_all(never);
}

// Sorts the particles by cell again, since neighbours in memory move apart. This affects only the computing time.
template <int d, bool mixed>
void HardSpheres<d, mixed>::sort_along_cells() {
    next_sort_ = work() + collisions_between_sorts * particles_.size();
    const u32 n = particles_.size();
    std::vector<u32> cell(n), now_at(n);
    for (u32 i = 0; i < n; ++i) cell[i] = particles_.pending[i].cell;
    const std::vector<u32> from = order_by_cell(cell);
    for (u32 i = 0; i < n; ++i) now_at[from[i]] = i;
    particles_.reorder(from, now_at);
    last_contacts_.reorder(from, now_at);
    cells_.fill();
    schedule_.rebuild();
}

}  // namespace hardlimit::boxes
