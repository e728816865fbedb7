// Criterion for rebuilding the neighbour list: a bound on the displacement of any body since the last build.
#pragma once
#include <algorithm>
#include <cstdint>

#include "../../base/math.hpp"

namespace hardlimit::boxes::steps {

// The list is valid until a body has moved by half the skin. The sum of the largest speeds bounds the displacements.
// When this bound is used up, displacements are measured, because in a dense box bodies do not get far.
//
// Steps are taken in batches, so that speeds are collected and contacts logged only once for many steps. A batch is so
// short that the bound holds if no speed exceeds a limit, with a reserve for a body that does so for one step: such a
// body ends the batch with the next step. Batches depend only on the state, and a pause does not change them, so lists
// are always rebuilt at the same steps. If a body was too fast even for the reserve, the measured displacements show
// whether the list was valid in the last step.
struct RebuildCriterion {
    static constexpr std::uint32_t most_steps = 64;  // in a batch

    double fastest = 0.0;                     // no body has been faster [m/s]
    double limit = 0.0;                       // on the speeds in a batch [m/s]
    double travelled = 0.0, allowance = 0.0;  // bound on the displacements, and its largest value [m]
    std::uint64_t batch_end = 0;              // number of steps taken at its end
    bool list_may_be_stale = false;           // a step was taken although a body may have moved too far

    bool holds() const { return travelled <= allowance; }
    void list_built(double skin) { travelled = 0.0, allowance = 0.5 * skin; }
    // Takes the measured largest displacement and speed. Returns whether the list may have missed a contact in the last
    // step.
    bool measured(double farthest, double largest_speed, double h, double skin) {
        fastest = largest_speed, travelled = 0.0;
        allowance = 0.5 * skin - farthest;
        const bool missed = list_may_be_stale && !(fastest * h <= allowance);
        list_may_be_stale = false;
        return missed;
    }
    // Begins a batch of at most `left` steps h under the gravity `pull` [m/s²]. The limit lets speeds grow by a
    // quarter, and the reserve lets one body be four times as fast for a step. If all bodies are at rest, nothing is
    // known about their speeds. A batch of many bodies is short, so that it can be stopped soon.
    void begin_batch(std::uint64_t taken, std::uint64_t left, std::size_t bodies, double pull, double h) {
        constexpr double growth = 1.25, reserve = 4.0, work = 4e6;  // work: bodies × steps, some 20 ms
        const double most = math::clamp(work / static_cast<double>(bodies), 1.0, double{most_steps});
        const double fall = most * pull * h;
        limit = growth * fastest + fall;
        const double room = (allowance - travelled) / ((limit + fall) * h) - reserve;
        const double fit = fastest > 0.0 && room > 1.0 ? math::min(room, most) : 1.0;
        batch_end = taken + std::min(static_cast<std::uint64_t>(fit), left);
    }
    // Adds a step. `speed`: the largest one in it if it exceeds `fastest`, else 0.
    void add_step(std::uint64_t taken, double speed, double pull, double h) {
        if (speed > limit) batch_end = std::min(batch_end, taken + 1);
        fastest = math::max(fastest, speed) + pull * h;
        travelled += fastest * h;
        list_may_be_stale = list_may_be_stale || (travelled > allowance && taken < batch_end);
    }
    template <class Archive>
    void exchange(Archive& archive) {
        archive(fastest), archive(limit), archive(travelled), archive(allowance), archive(batch_end);
        archive(list_may_be_stale);
    }
};

}  // namespace hardlimit::boxes::steps
