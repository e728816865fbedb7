// Creates or loads the event-driven engine of Newton's equations for a contact law.
#pragma once
#include <memory>

#include "../common/archive.hpp"
#include "../common/engine.hpp"
#include "../common/newton_setting.hpp"
#include "../kernels/interface.hpp"

namespace hardlimit::boxes {

// The engine of one law, new or continued: Source is `const System` or `Reader`. Defined in engine.hpp, which each law
// compiles in a source file of its own: with several laws in one file, gcc would inline less.
template <class Law, class Source>
std::unique_ptr<Engine> newton_events_of(const NewtonSetting& setting, Source& source,
                                         const hardlimit_abi::TouchKernels& kernels);

inline std::unique_ptr<Engine> make_newton_events(const System& s, const LawChoice& law, bool keep_log,
                                                  const hardlimit_abi::TouchKernels& kernels) {
    const NewtonSetting setting(s, law, keep_log);
    return with_contact_law<std::unique_ptr<Engine>>(
        law, [&]<class Law>() { return newton_events_of<Law>(setting, s, kernels); });
}

// Returns nullptr if the bytes are not a complete checkpoint of this engine.
inline std::unique_ptr<Engine> load_newton_events(const char* data, std::size_t n,
                                                  const hardlimit_abi::TouchKernels& kernels) {
    Reader reader(data, n);
    if (!reader.whole("newton_events")) return nullptr;
    NewtonSetting setting;
    setting.exchange(reader);
    if (reader.failed()) return nullptr;
    auto engine = with_contact_law<std::unique_ptr<Engine>>(
        setting.law, [&]<class Law>() { return newton_events_of<Law>(setting, reader, kernels); });
    return reader.failed() ? nullptr : std::move(engine);
}

}  // namespace hardlimit::boxes
