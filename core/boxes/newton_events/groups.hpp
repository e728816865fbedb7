// The groups of bodies in contact.
#pragma once
#include <vector>

#include "../queue/calendar_queue.hpp"
#include "records.hpp"

namespace hardlimit::boxes::events {

// Records of the groups by index. A record is used again after its group has ended.
template <class Law>
class Groups {
public:
    using Group = ContactGroup<Law>;

    explicit Groups(std::size_t bodies) : prefetches_(bodies > most_in_caches) {}

    Group& operator[](int index) { return records_[static_cast<std::size_t>(index)]; }
    const Group& operator[](int index) const { return records_[static_cast<std::size_t>(index)]; }
    int size() const { return static_cast<int>(records_.size()); }

    bool prefetches() const { return prefetches_; }  // whether the data of the bodies exceed the caches

    // Index of an unused record.
    int add() {
        if (free_.empty()) {
            records_.emplace_back();
            return size() - 1;
        }
        const int index = free_.back();
        free_.pop_back();
        return index;
    }
    // Frees the record of a group, and prefetches it, since the next group will soon reuse it.
    void discard(int index) {
        Group& g = (*this)[index];
        g.alive = false;
        free_.push_back(index);
        if (!prefetches_) return;
        for (std::size_t k = 0; k < sizeof g; k += 64) prefetch(reinterpret_cast<const char*>(&g) + k);
    }
    // Calls f(index, group) for all groups.
    template <class F>
    void for_all(const F& f) const {
        for (int index = 0; index < size(); ++index)
            if ((*this)[index].alive) f(index, (*this)[index]);
    }

    // For checkpoints.
    Records<Group>& records() { return records_; }
    const Records<Group>& records() const { return records_; }
    std::vector<int>& unused() { return free_; }
    std::size_t bytes() const { return records_.capacity() * sizeof(Group); }

private:
    Records<Group> records_;
    std::vector<int> free_;
    const bool prefetches_;
};

}  // namespace hardlimit::boxes::events
