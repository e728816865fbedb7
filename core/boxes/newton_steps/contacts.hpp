// Open contacts of the stepping engine, and the log of those that have ended.
#pragma once
#include <array>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "../common/bodies.hpp"
#include "../common/contact_record.hpp"
#include "contact_force.hpp"

namespace hardlimit::boxes::steps {

inline constexpr std::uint32_t no_body = 0xffffffffu;

// What the log needs to know of a contact that has begun.
struct ContactBegin {
    std::int32_t first, second;                     // original indices; second as in ContactRecord
    double begin, impact_speed;                     // [s], [m/s]
    bool overlapped;                                // at its begin a body had another contact
    std::uint32_t overlaps_first, overlaps_second;  // of the bodies at the begin (ContactLog)
};

// Two bodies, or a body and a wall, that overlap. They are in contact while their force is repulsive.
template <class Law>
struct Contact : ContactBegin, ContactForce {  // the force of the last step
    Law law;
    std::array<std::int32_t, 3> image;        // of the second body along the unfolded paths, in edges
    std::uint32_t index_first, index_second;  // in Bodies; no_body: a free slot (first), a wall (second)
    Double4 normal;                           // unit vector from the first to the second
    double distance;                          // of the centres, or to the wall [m]
    double compression;                       // at the last step [m]
    double damped;                            // impulse of the damping during the last step [N s]
    double excess;                            // of the compression over the slack of the law [m]
    Onset onset;
    bool is_new;  // the last step was its first
    bool in_contact;
    std::int32_t begin_event;  // index of its begin among the events of the slab; −1 once it is in the log
};

// The begin or the end of a contact between two steps. It is logged after several steps, when the slot of the contact
// may have been reused.
struct ContactEvent {
    ContactBegin contact;
    std::uint64_t step;  // that detected it
    double time;         // [s]
    std::int32_t slot;
    bool begins;
    double separation_speed;  // [m/s]
    std::int32_t
        begin_event;  // of an end: index of the begin among the events, −1 if it is already in the log

    std::tuple<std::uint64_t, double, std::int32_t, std::int32_t> order() const {
        return {step, time, contact.first, contact.second};
    }
};

// Counts contacts, and finds those that share a body with another contact while they last. For each body it counts the
// open contacts and the overlaps, which are contacts that began while the body had another one. A contact overlapped if
// it began as such, or if the count of overlaps of one of its bodies has grown since.
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
    void end(const ContactBegin& t, double time, double separation_speed) {
        const ContactRecord row = record(t, time, separation_speed);
        ++ended_;
        overlapped_ += row.overlapped;
        --bodies_[static_cast<std::size_t>(t.first)].open;
        if (t.second >= 0) --bodies_[static_cast<std::size_t>(t.second)].open;
        if (keep_) rows_.push_back(row);
    }
    ContactRecord record(const ContactBegin& t, double end, double separation_speed) const {
        const bool overlapped = t.overlapped || overlaps(t.first) != t.overlaps_first ||
                                (t.second >= 0 && overlaps(t.second) != t.overlaps_second);
        const bool in_order = t.second < 0 || t.first < t.second;
        return {t.begin,
                end,
                in_order ? t.first : t.second,
                in_order ? t.second : t.first,
                t.impact_speed,
                separation_speed,
                overlapped};
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

}  // namespace hardlimit::boxes::steps
