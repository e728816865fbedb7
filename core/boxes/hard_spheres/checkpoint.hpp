// Saves and loads a run.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Type of the engine, stored at the start of a checkpoint.
struct Kind {
    int dimension;
    bool mixed;
};

template <int d, bool mixed>
std::vector<char> HardSpheres<d, mixed>::save() const {
    Writer w("hard_spheres");
    w(Kind{d, mixed});
    HardSpheres& self = const_cast<HardSpheres&>(*this);  // a Writer changes nothing
    self.setting_.exchange(w);
    self.exchange(w);
    return w.finish();
}

template <int d, bool mixed>
HardSpheres<d, mixed>::HardSpheres(Reader& saved, const hardlimit_abi::TouchKernels& kernels)
    : HardSpheres(spheres::Setting(saved), kernels) {
    exchange(saved);
    if (saved.failed()) return;
    cells_.resume();
    schedule_.rebuild();
}

// All but the setting.
template <int d, bool mixed>
template <class Archive>
void HardSpheres<d, mixed>::exchange(Archive& a) {
    particles_.exchange(a);
    totals_.exchange(a);
    a(particles_.now), a(paused_);
    log_.exchange(a);
    last_contacts_.exchange(a);
    collisions_.exchange(a);
    cells_.exchange(a);
    collapse_.archive(a);
}

}  // namespace hardlimit::boxes
