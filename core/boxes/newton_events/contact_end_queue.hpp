// Which contact ends next, of those that nothing has disturbed so far.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

#include "../common/particle.hpp"

namespace hardlimit::boxes {

// The end of an undisturbed contact: of a group, by its first member.
struct ContactEnd {
    double time;  // [s]
    int first, group;
};

// Contacts that last equally long end in the order in which they began: they wait in line. Others wait in a heap.
class ContactEndQueue {
public:
    // Name: what orders simultaneous ones, by their first members. Written number by number where it stays: a copy in
    // one piece would have to wait for the numbers.
    template <class Name>
    void push(double time, int first, int group, const Name& name) {
        if (begin_ > line_.size() / 2) {
            line_.erase(line_.begin(), line_.begin() + static_cast<std::ptrdiff_t>(begin_));
            begin_ = 0;
        }
        const bool in_line = begin_ == line_.size() || later({time, first, group}, line_.back(), name);
        std::vector<ContactEnd>& to = in_line ? line_ : heap_;
        to.emplace_back();
        ContactEnd& ending = to.back();
        ending.time = time, ending.first = first, ending.group = group;
        if (!in_line) std::push_heap(heap_.begin(), heap_.end(), by(name));
    }
    // The first one that still stands, or nullptr. It stays until pop().
    template <class Stands, class Name>
    const ContactEnd* next(const Stands& stands, const Name& name) {
        while (begin_ < line_.size() && !stands(line_[begin_])) ++begin_;
        while (!heap_.empty() && !stands(heap_.front())) pop_heap(name);
        const bool line = begin_ < line_.size();
        if (!line && heap_.empty()) return nullptr;
        from_heap_ = !line || (!heap_.empty() && later(line_[begin_], heap_.front(), name));
        return from_heap_ ? &heap_.front() : &line_[begin_];
    }
    // The one that next() gave.
    template <class Name>
    void pop(const Name& name) {
        if (from_heap_)
            pop_heap(name);
        else
            ++begin_;
    }
    // Of those to come: far(ending) where it is some way off, near(ending) nearer.
    template <class Far, class Near>
    void ahead(const Far& far, const Near& near) const {
        if (begin_ + 8 < line_.size()) far(line_[begin_ + 8]);
        if (begin_ + 4 < line_.size()) near(line_[begin_ + 4]);
        for (std::size_t k = 3; k < std::min<std::size_t>(7, heap_.size()); ++k) far(heap_[k]);
        for (std::size_t k = 1; k < std::min<std::size_t>(3, heap_.size()); ++k) near(heap_[k]);
    }

private:
    std::vector<ContactEnd> line_, heap_;
    std::size_t begin_ = 0;  // of those in line
    bool from_heap_ = false;

    template <class Name>
    void pop_heap(const Name& name) {
        std::pop_heap(heap_.begin(), heap_.end(), by(name));
        heap_.pop_back();
    }

    template <class Name>
    static bool later(const ContactEnd& a, const ContactEnd& b, const Name& name) {
        return a.time != b.time ? a.time > b.time : name(a.first) > name(b.first);
    }
    template <class Name>
    static auto by(const Name& name) {
        return [&name](const ContactEnd& a, const ContactEnd& b) { return later(a, b, name); };
    }
};

}  // namespace hardlimit::boxes
