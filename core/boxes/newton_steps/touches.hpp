// Contacts that last, and the log of those that are over.
#pragma once
#include <array>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "../common/bodies.hpp"
#include "../common/contact_record.hpp"
#include "strength.hpp"

namespace hardlimit::boxes::steps {

// What the log says of a contact.
struct Record {
    std::int32_t first, second;  // numbers; second as in ContactRow
    double begin, impact_speed;
    bool overlapped;
    std::uint32_t crowd_first, crowd_second;
};

// Two bodies, or a body and a wall, that overlap. They are in contact (`closed`) while they push each other.
template <class Law>
struct Touch : Record, Strength {  // the force of the last step
    Law law;
    std::array<std::int32_t, 3> turns;  // by which image of the second, in edges along the unfolded paths
    std::uint32_t at_first, at_second;  // indices; the second is none at a wall
    Four normal;                        // unit vector from the one at `at_first` to the other
    double distance;                    // of the centres, or to the wall [m]
    double compression;                 // at the last step [m]
    double damped;                      // impulse of damping in the step that led there [N s]
    double margin;                      // how far ξ is above the law's slack [m]
    Onset onset;
    bool fresh;  // the last step was its first
    bool closed;
    std::int32_t news;  // where its begin is among the changes of the slab, −1 once the log knows of it
};
inline constexpr std::uint32_t nobody = 0xffffffffu;

// The begin or the end of a contact between two steps. When the log comes to hear of it, others may have its slot.
struct Change {
    Record contact;
    std::uint64_t step;  // that found it
    double time;
    std::int32_t slot;
    bool begins;
    double separation_speed;
    std::int32_t since;  // of an end: where the begin is among the changes, −1 if the log knows of it

    std::tuple<std::uint64_t, double, std::int32_t, std::int32_t> order() const {
        return {step, time, contact.first, contact.second};
    }
};

// Who is in contact how often, from which it follows which contacts share a body while they last.
class ContactLog {
public:
    ContactLog(std::size_t bodies, bool keep) : company_(bodies), keep_(keep) {}

    std::uint64_t begun() const { return begun_; }
    std::uint64_t pairs() const { return pairs_; }  // of them with another body, not a wall
    std::uint64_t ended() const { return ended_; }
    std::uint64_t overlapped() const { return overlapped_; }

    void begins(Record& t) {
        ++begun_;
        t.overlapped = joins(t.first, t.crowd_first);
        if (t.second < 0) return;
        ++pairs_;
        t.overlapped = joins(t.second, t.crowd_second) || t.overlapped;
    }
    void ends(const Record& t, double time, double separation_speed) {
        const ContactRow row = so_far(t, time, separation_speed);
        ++ended_;
        overlapped_ += row.overlapped;
        --company_[static_cast<std::size_t>(t.first)].contacts;
        if (t.second >= 0) --company_[static_cast<std::size_t>(t.second)].contacts;
        if (keep_) rows_.push_back(row);
    }
    ContactRow so_far(const Record& t, double end, double separation_speed) const {
        const bool crowded = t.overlapped || crowd(t.first) != t.crowd_first ||
                             (t.second >= 0 && crowd(t.second) != t.crowd_second);
        const bool in_order = t.second < 0 || t.first < t.second;
        return {t.begin,
                end,
                in_order ? t.first : t.second,
                in_order ? t.second : t.first,
                t.impact_speed,
                separation_speed,
                crowded};
    }
    std::vector<ContactRow> take() { return std::exchange(rows_, {}); }

    template <class Archive>
    void exchange(Archive& archive) {
        archive(company_), archive(rows_), archive(keep_), archive(begun_), archive(pairs_), archive(ended_),
            archive(overlapped_);
    }

private:
    struct Company {
        std::uint32_t contacts, crowd;  // now, and how often one began beside another one
    };
    std::vector<Company> company_;  // [N] by number
    std::vector<ContactRow> rows_;
    bool keep_;
    std::uint64_t begun_ = 0, pairs_ = 0, ended_ = 0, overlapped_ = 0;

    std::uint32_t crowd(std::int32_t body) const { return company_[static_cast<std::size_t>(body)].crowd; }
    bool joins(std::int32_t body, std::uint32_t& crowd) {
        Company& c = company_[static_cast<std::size_t>(body)];
        const bool beside = c.contacts++ > 0;
        crowd = c.crowd += beside;
        return beside;
    }
};

}  // namespace hardlimit::boxes::steps
