// Saves and loads a run.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <class Law>
std::vector<char> NewtonSteps<Law>::save() const {
    Writer writer("newton_steps");
    NewtonSteps& self = const_cast<NewtonSteps&>(*this);  // a Writer changes nothing
    self.setting_.exchange(writer);
    self.exchange(writer);
    return writer.finish();
}

template <class Law>
NewtonSteps<Law>::NewtonSteps(const NewtonSetting& setting, Reader& reader) : NewtonSteps(setting) {
    exchange(reader);
}

// All but the setting.
template <class Law>
template <class Archive>
void NewtonSteps<Law>::exchange(Archive& archive) {
    domain_.exchange(archive);
    criterion_.exchange(archive);
    archive(time_), archive(plan_.h), archive(taken_), archive(now_), archive(outcome_);
    archive(ended_by_), archive(ended_at_wall_);
    archive(plan_.from), archive(plan_.until), archive(plan_.planned), archive(plan_.done), archive(paused_);
    log_.exchange(archive);
}

}  // namespace hardlimit::boxes
