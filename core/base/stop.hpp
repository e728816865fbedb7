// A stop request that a long computation polls; polling costs no more than a counter.
#pragma once
#include "portable.hpp"

namespace hardlimit {

// Every 64th poll calls the callback, and a yes is final. Without a callback the answer is always no.
class Stop {
public:
    using Ask = bool (*)(void*);

    Stop() = default;
    Stop(Ask ask, void* context) : ask_(ask), context_(context) {}

    // For every step of a computation.
    HL_FN_INLINE bool operator()() { return stopped_ || (ask_ && (++steps_ & 63u) == 0 && now()); }
    // For long steps: always passed on.
    bool now() { return stopped_ = stopped_ || (ask_ && ask_(context_)); }
    bool stopped() const { return stopped_; }

private:
    Ask ask_ = nullptr;
    void* context_ = nullptr;
    unsigned steps_ = 0;
    bool stopped_ = false;
};

}  // namespace hardlimit
