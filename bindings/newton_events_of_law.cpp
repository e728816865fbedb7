// Compiles the event-driven engine for Newton's equations for one law: once for each law of the registry, without
// and with friction.
#include "boxes/newton_events/engine.hpp"

namespace hardlimit::boxes {

#define HARDLIMIT_ENGINE_FROM(Source)                                         \
    template std::unique_ptr<Engine> newton_events_of<HARDLIMIT_LAW, Source>( \
        const NewtonSetting&, Source&, const hardlimit_abi::TouchKernels&);
HARDLIMIT_ENGINE_FROM(const System)
HARDLIMIT_ENGINE_FROM(Reader)

}  // namespace hardlimit::boxes
