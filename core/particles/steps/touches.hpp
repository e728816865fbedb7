// Contacts that last, and the log of those that are over.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "../contact_row.hpp"
#include "bodies.hpp"
#include "onset.hpp"

namespace hardlimit::particles::steps {

// Two bodies, or a body and a wall, that overlap. They are in contact (`closed`) while they push each other.
template <class Law>
struct Touch {
    Law law;
    std::int32_t first, second;         // numbers; second as in ContactRow
    std::array<std::int32_t, 3> turns;  // by which image of the second, in edges along the unfolded paths
    std::uint32_t at_first, at_second;  // indices; the second is none at a wall
    Four normal;                        // unit vector from the one at `at_first` to the other
    double distance;                    // of the centres, or to the wall [m]
    double force, loss, compression;    // at the last step [N], [W], [m]
    double margin;                      // how far ξ is above the law's slack [m]
    Onset onset;
    bool fresh;  // the last step was its first
    bool closed;
    bool overlapped;
    double begin, impact_speed;
    std::uint32_t crowd_first, crowd_second;
};
inline constexpr std::uint32_t nobody = 0xffffffffu;

// The begin or the end of a contact between two steps.
struct Change {
    double time;
    std::uint32_t slab, slot;
    bool begins;
    double separation_speed;
};

// Who is in contact how often, from which it follows which contacts share a body while they last.
class ContactLog {
public:
    ContactLog(std::size_t bodies, bool keep) : company_(bodies), keep_(keep) {}

    std::uint64_t begun() const { return begun_; }
    std::uint64_t pairs() const { return pairs_; }  // of them with another body, not a wall
    std::uint64_t ended() const { return ended_; }
    std::uint64_t overlapped() const { return overlapped_; }

    template <class Law>
    void begins(Touch<Law>& t) {
        ++begun_;
        t.overlapped = joins(t.first, t.crowd_first);
        if (t.second < 0) return;
        ++pairs_;
        t.overlapped = joins(t.second, t.crowd_second) || t.overlapped;
    }
    template <class Law>
    void ends(const Touch<Law>& t, double time, double separation_speed) {
        const ContactRow row = so_far(t, time, separation_speed);
        ++ended_;
        overlapped_ += row.overlapped;
        --company_[static_cast<std::size_t>(t.first)].contacts;
        if (t.second >= 0) --company_[static_cast<std::size_t>(t.second)].contacts;
        if (keep_) rows_.push_back(row);
    }
    template <class Law>
    ContactRow so_far(const Touch<Law>& t, double end, double separation_speed) const {
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

}  // namespace hardlimit::particles::steps
