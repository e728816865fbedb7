// The collisions of a run, and how it ended.
#pragma once
#include <algorithm>
#include <utility>
#include <vector>

#include "../common/engine.hpp"
#include "../common/particle.hpp"
#include "../common/storage.hpp"

namespace hardlimit::boxes::spheres {

// What the log holds of a collision.
struct CollisionResult {
    double separation_speed, lost;  // [m/s], dissipated energy [J]
    // With friction.
    double friction_loss = 0.0;                                               // part of `lost`
    double tangential_speed = math::nan, tangential_restitution = math::nan;  // [m/s]
    bool slid = false;
};

// Particles are given by their index in memory; `second` of a collision is a particle or the number of a wall.
class CollisionLog {
public:
    CollisionLog(const Records<u32>& original_index, const bool& keep)
        : original_index_(original_index), keep_(keep) {}

    void add(double now, u32 i, i64 second, double speed, const CollisionResult& result) {
        if (!keep_) return;
        const auto [first, last] = original(i, second);
        rows_.push_back({now, now, static_cast<std::int32_t>(first), static_cast<std::int32_t>(last), speed,
                         result.separation_speed, false, result.slid, result.tangential_speed,
                         result.tangential_restitution});
    }
    std::vector<ContactRecord> take() { return std::exchange(rows_, {}); }

    // Ends the run at a collision.
    void end_run(Outcome outcome, double now, u32 i, i64 second) {
        const auto [first, last] = original(i, second);
        outcome_ = outcome;
        early_end_ = {now, {first}, WallId::of(last)};
        if (!early_end_.wall) early_end_.particles.push_back(last);
    }
    Outcome outcome() const { return outcome_; }
    const EarlyEnd& early_end() const { return early_end_; }

    template <class Archive>
    void exchange(Archive& a) {
        a(outcome_), a(rows_), a(early_end_.time), a(early_end_.particles), a(early_end_.wall);
    }

private:
    const Records<u32>& original_index_;
    const bool& keep_;
    std::vector<ContactRecord> rows_;
    Outcome outcome_ = Outcome::ok;
    EarlyEnd early_end_;

    // Original indices in ascending order; a wall keeps its number and its place.
    std::pair<i64, i64> original(u32 i, i64 second) const {
        const i64 a = original_index_[i];
        if (second < 0) return {a, second};
        return std::minmax({a, i64{original_index_[static_cast<u32>(second)]}});
    }
};

}  // namespace hardlimit::boxes::spheres
