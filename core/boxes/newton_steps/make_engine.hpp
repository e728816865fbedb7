// Creates or loads the time-stepping engine for a contact law.
#pragma once
#include <memory>

#include "engine.hpp"

namespace hardlimit::boxes {

inline std::unique_ptr<Engine> make_newton_steps(const System& s, const LawChoice& law, bool keep_log,
                                                 double time_step) {
    const NewtonSetting setting(s, law, keep_log, time_step);
    return with_contact_law<std::unique_ptr<Engine>>(law, [&]<class Law>() -> std::unique_ptr<Engine> {
        return std::make_unique<NewtonSteps<Law>>(setting, s);
    });
}

// Returns nullptr if the bytes are not a complete checkpoint of this engine.
inline std::unique_ptr<Engine> load_newton_steps(const char* data, std::size_t n) {
    Reader reader(data, n);
    if (!reader.whole("newton_steps")) return nullptr;
    NewtonSetting setting;
    setting.exchange(reader);
    if (reader.failed()) return nullptr;
    auto engine =
        with_contact_law<std::unique_ptr<Engine>>(setting.law, [&]<class Law>() -> std::unique_ptr<Engine> {
            return std::make_unique<NewtonSteps<Law>>(setting, reader);
        });
    return reader.failed() ? nullptr : std::move(engine);
}

}  // namespace hardlimit::boxes
