// The events of all bodies in the order of time, and the prefetching of their data.
#pragma once
#include "../queue/calendar_queue.hpp"
#include "../queue/prefetch.hpp"
#include "body_cells.hpp"
#include "contact_end_queue.hpp"
#include "predict.hpp"

namespace hardlimit::boxes::events {

// Simultaneous events are ordered by original index. The end of a cluster is an event of its first member. The ends of
// isolated contacts have a short queue of their own, and the pending events of their members stay valid.
template <class Law>
class Schedule {
public:
    struct Due {
        double time;  // [s]; infinity: none
        int body;     // whose pending event it is
        int group;    // whose isolated contact ends; −1: an event of a body
    };

    Schedule(const Paths<Law>& paths, const BodyCells<Law>& cells, const Groups<Law>& groups,
             Predictor<Law>& predictor)
        : paths_(paths), cells_(cells), groups_(groups), predictor_(predictor) {}

    // Predicts the events of body i and schedules them.
    void renew(int i) {
        predictor_.predict(i);
        push(i);
    }
    // After the events of body i have been predicted.
    void push(int i) {
        const u32 id = static_cast<u32>(i);
        bodies_.push(id, paths_.pending[id].time(), paths_.by_original_index());
    }
    // Schedules the end of the isolated contact whose first member is body i.
    void push_contact_end(int i) {
        const BodyEvents& e = paths_.pending[i];
        contact_ends_.push(e.end, i, e.group, paths_.by_original_index());
    }
    // After the events of all bodies have been predicted.
    void rebuild() { bodies_.rebuild(static_cast<u32>(paths_.size()), time(), paths_.by_original_index()); }

    Due next() {
        const auto original = paths_.by_original_index();
        const QueuedEvent* due = bodies_.next(time(), original, [this] {
            if (groups_.prefetches()) prefetcher().enter_bin();
        });
        const auto valid = [this](const ContactEnd& of) {
            const BodyEvents& e = paths_.pending[of.first];
            return e.end == of.time && e.group == of.group && !e.clustered;
        };
        const ContactEnd* ending = contact_ends_.next(valid, original);
        if (ending && !(due && due->time < ending->time)) return {ending->time, ending->first, ending->group};
        return due ? Due{due->time, static_cast<int>(due->id), -1} : Due{math::infinity, -1, -1};
    }
    // Removes the event that next() returned.
    void pop(const Due& due) {
        if (due.group >= 0) {
            contact_ends_.pop(paths_.by_original_index());
            if (groups_.prefetches()) prefetch_contact_ends();
        } else {
            bodies_.pop();
            if (groups_.prefetches()) prefetcher().step();
        }
    }

    std::size_t bytes() const { return bodies_.bytes(); }

private:
    const Paths<Law>& paths_;
    const BodyCells<Law>& cells_;
    const Groups<Law>& groups_;
    Predictor<Law>& predictor_;
    CalendarQueue bodies_;
    ContactEndQueue contact_ends_;

    auto time() const {
        return [this](u32 id) { return paths_.pending[id].time(); };
    }
    auto prefetcher() const {
        return Prefetcher{bodies_,
                          cells_.cells(),
                          paths_.pending.data(),
                          paths_.particles.data(),
                          [this](u32) { return cells_.level(); },
                          [this](u32 id) { paths_.laws().fetch(id); },
                          [this](u32 id) { prefetch(&paths_.pending[id]); }};
    }
    void prefetch_contact_ends() const {
        const auto fetch_body = [this](int i) {
            prefetch(&paths_.pending[i]);
            prefetch(&paths_.particles[i]);
        };
        const auto record = [&](const ContactEnd& of) {
            prefetch(&groups_[of.group]);
            fetch_body(of.first);
        };
        const auto second = [&](const ContactEnd& of) {
            const int i = groups_[of.group].isolated_contact.body[1];
            if (i >= 0) fetch_body(i);
        };
        contact_ends_.ahead(record, second);
    }
};

}  // namespace hardlimit::boxes::events
