// Contact log of the time-stepping engine.
#pragma once
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "../common/engine.hpp"
#include "slab.hpp"

namespace hardlimit::boxes::steps {

// Counts contacts, and finds those that overlapped: they shared a body with another contact at some time. For each body
// it counts the open contacts and the overlaps, that is, contacts that began while the body had another one. A contact
// overlapped if it began so, or if the count of overlaps of one of its bodies has grown since.
class ContactLog {
public:
    ContactLog(std::size_t bodies, bool keep) : bodies_(bodies), keep_(keep) {}

    std::uint64_t begun() const { return begun_; }
    std::uint64_t pairs() const { return pairs_; }  // without walls
    std::uint64_t ended() const { return ended_; }
    std::uint64_t overlapped() const { return overlapped_; }

    void begin(ContactBegin& t) {
        ++begun_;
        t.overlapped = add_contact(t.first, t.overlaps_first);
        if (t.second < 0) return;
        ++pairs_;
        t.overlapped = add_contact(t.second, t.overlaps_second) || t.overlapped;
    }
    void end(const ContactBegin& t, double time, double separation_speed, const Sliding& sliding) {
        const ContactRecord row = record(t, time, separation_speed, sliding);
        ++ended_;
        overlapped_ += row.overlapped;
        --bodies_[static_cast<std::size_t>(t.first)].open;
        if (t.second >= 0) --bodies_[static_cast<std::size_t>(t.second)].open;
        if (keep_) rows_.push_back(row);
    }
    ContactRecord record(const ContactBegin& t, double end, double separation_speed,
                         const Sliding& sliding) const {
        const bool overlapped = t.overlapped || overlaps(t.first) != t.overlaps_first ||
                                (t.second >= 0 && overlaps(t.second) != t.overlaps_second);
        const bool in_order = t.second < 0 || t.first < t.second;
        return {t.begin,
                end,
                in_order ? t.first : t.second,
                in_order ? t.second : t.first,
                t.impact_speed,
                separation_speed,
                overlapped,
                sliding.slid,
                sliding.speed,
                sliding.restitution};
    }
    std::vector<ContactRecord> take() { return std::exchange(rows_, {}); }

    template <class Archive>
    void exchange(Archive& archive) {
        archive(bodies_), archive(rows_), archive(keep_), archive(begun_), archive(pairs_), archive(ended_),
            archive(overlapped_);
    }

private:
    struct BodyContacts {
        std::uint32_t open, overlaps;
    };
    std::vector<BodyContacts> bodies_;  // [N] by original index
    std::vector<ContactRecord> rows_;
    bool keep_;
    std::uint64_t begun_ = 0, pairs_ = 0, ended_ = 0, overlapped_ = 0;

    std::uint32_t overlaps(std::int32_t body) const {
        return bodies_[static_cast<std::size_t>(body)].overlaps;
    }
    bool add_contact(std::int32_t body, std::uint32_t& overlaps) {
        BodyContacts& c = bodies_[static_cast<std::size_t>(body)];
        const bool overlapping = c.open++ > 0;
        overlaps = c.overlaps += overlapping;
        return overlapping;
    }
};

// Logs the events of all slabs in the order of their times, and clears them.
template <class Law>
void log_events(std::vector<Slab<Law>>& slabs, ContactLog& log) {
    std::vector<std::pair<Slab<Law>*, std::int32_t>> events;  // slab, index in its events
    for (Slab<Law>& s : slabs)
        for (std::size_t at = 0; at < s.events.size(); ++at)
            events.push_back({&s, static_cast<std::int32_t>(at)});
    const auto event = [](const auto& where) -> ContactEvent& {
        return where.first->events[static_cast<std::size_t>(where.second)];
    };
    std::ranges::stable_sort(events, {}, [&](const auto& where) { return event(where).order(); });
    for (const auto& where : events) {
        ContactEvent& e = event(where);
        if (e.begins) {
            log.begin(e.contact);
            Contact<Law>& c = where.first->contacts[static_cast<std::size_t>(e.slot)];
            if (c.begin_event != where.second) continue;  // it has ended already
            static_cast<ContactBegin&>(c) = e.contact;
            c.begin_event = -1;
        } else {
            const bool logged = e.begin_event < 0;
            log.end(logged ? e.contact : event(std::pair(where.first, e.begin_event)).contact, e.time,
                    e.separation_speed, e.sliding);
        }
    }
    for (Slab<Law>& s : slabs) s.events.clear();
}

}  // namespace hardlimit::boxes::steps
