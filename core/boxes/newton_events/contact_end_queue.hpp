// Queue of the ends of isolated contacts.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

#include "../common/particle.hpp"

namespace hardlimit::boxes {

// End of the contact of a group; `first` is its first member.
struct ContactEnd {
    double time;  // [s]
    int first, group;
};

// Contacts of equal duration end in the order in which they begin, so their ends are kept in a first-in-first-out
// queue. All other ends are kept in a heap.
class ContactEndQueue {
public:
    // TieBreak: orders simultaneous ends by the first member. The record is set element by element: a copy of a record
    // just written would stall (store forwarding).
    template <class TieBreak>
    void push(double time, int first, int group, const TieBreak& tie_break) {
        if (begin_ > line_.size() / 2) {
            line_.erase(line_.begin(), line_.begin() + static_cast<std::ptrdiff_t>(begin_));
            begin_ = 0;
        }
        const bool in_line = begin_ == line_.size() || later({time, first, group}, line_.back(), tie_break);
        std::vector<ContactEnd>& to = in_line ? line_ : heap_;
        to.emplace_back();
        ContactEnd& ending = to.back();
        ending.time = time, ending.first = first, ending.group = group;
        if (!in_line) std::push_heap(heap_.begin(), heap_.end(), by(tie_break));
    }
    // The first valid end, or nullptr. It stays until pop().
    template <class Valid, class TieBreak>
    const ContactEnd* next(const Valid& valid, const TieBreak& tie_break) {
        while (begin_ < line_.size() && !valid(line_[begin_])) ++begin_;
        while (!heap_.empty() && !valid(heap_.front())) pop_heap(tie_break);
        const bool line = begin_ < line_.size();
        if (!line && heap_.empty()) return nullptr;
        from_heap_ = !line || (!heap_.empty() && later(line_[begin_], heap_.front(), tie_break));
        return from_heap_ ? &heap_.front() : &line_[begin_];
    }
    // Removes the end that next() returned.
    template <class TieBreak>
    void pop(const TieBreak& tie_break) {
        if (from_heap_)
            pop_heap(tie_break);
        else
            ++begin_;
    }
    // For prefetching: calls far(end) for ends some way ahead, near(end) for closer ones.
    template <class Far, class Near>
    void ahead(const Far& far, const Near& near) const {
        if (begin_ + 8 < line_.size()) far(line_[begin_ + 8]);
        if (begin_ + 4 < line_.size()) near(line_[begin_ + 4]);
        for (std::size_t k = 3; k < std::min<std::size_t>(7, heap_.size()); ++k) far(heap_[k]);
        for (std::size_t k = 1; k < std::min<std::size_t>(3, heap_.size()); ++k) near(heap_[k]);
    }

private:
    std::vector<ContactEnd> line_, heap_;
    std::size_t begin_ = 0;  // first end in line_
    bool from_heap_ = false;

    template <class TieBreak>
    void pop_heap(const TieBreak& tie_break) {
        std::pop_heap(heap_.begin(), heap_.end(), by(tie_break));
        heap_.pop_back();
    }

    template <class TieBreak>
    static bool later(const ContactEnd& a, const ContactEnd& b, const TieBreak& tie_break) {
        return a.time != b.time ? a.time > b.time : tie_break(a.first) > tie_break(b.first);
    }
    template <class TieBreak>
    static auto by(const TieBreak& tie_break) {
        return [&tie_break](const ContactEnd& a, const ContactEnd& b) { return later(a, b, tie_break); };
    }
};

}  // namespace hardlimit::boxes
