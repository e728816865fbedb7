// Containers for arrays of many millions of records: on huge pages if available, without doubling their capacity.
#pragma once
#include <algorithm>
#include <cstddef>
#include <new>
#include <vector>

#include "../../base/portable.hpp"

namespace hardlimit::boxes {

template <class T>
struct HugePageAllocator {
    using value_type = T;
    static constexpr std::size_t page = std::size_t{2} << 20;

    HugePageAllocator() = default;
    template <class U>
    HugePageAllocator(const HugePageAllocator<U>&) {}

    T* allocate(std::size_t n) {
        const std::size_t bytes = n * sizeof(T);
        if (bytes < 2 * page) return static_cast<T*>(::operator new(bytes, std::align_val_t{alignof(T)}));
        void* p = ::operator new(bytes, std::align_val_t{page});
        advise_huge_pages(p, bytes);
        return static_cast<T*>(p);
    }
    void deallocate(T* p, std::size_t n) {
        ::operator delete(p, std::align_val_t{n * sizeof(T) < 2 * page ? alignof(T) : page});
    }
    bool operator==(const HugePageAllocator&) const { return true; }
};

template <class T>
using Records = std::vector<T, HugePageAllocator<T>>;

// Scratch memory aligned to pages: a vector store across a page boundary costs as much as twenty aligned ones.
template <class T>
struct PageAllocator {
    using value_type = T;
    static constexpr std::align_val_t page{4096};

    PageAllocator() = default;
    template <class U>
    PageAllocator(const PageAllocator<U>&) {}

    T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), page)); }
    void deallocate(T* p, std::size_t) { ::operator delete(p, page); }
    bool operator==(const PageAllocator&) const { return true; }
};

template <class T>
using Scratch = std::vector<T, PageAllocator<T>>;

// Reserves space for one more record; large arrays grow by a quarter.
template <class T>
void reserve_one(Records<T>& records) {
    if (records.size() == records.capacity() && records.size() > 1000)
        records.reserve(records.size() + records.size() / 4);
}

// A list with a small buffer: up to `most_in_place` elements are stored in the object itself.
template <class T, std::size_t most_in_place>
class SmallVector {
public:
    std::size_t size() const { return size_; }
    T* begin() { return size_ <= most_in_place ? few_ : many_.data(); }
    T* end() { return begin() + size_; }
    const T* begin() const { return size_ <= most_in_place ? few_ : many_.data(); }
    const T* end() const { return begin() + size_; }
    T& operator[](std::size_t i) { return begin()[i]; }
    const T& operator[](std::size_t i) const { return begin()[i]; }

    // Does not preserve the elements.
    void resize(std::size_t size) {
        size_ = size;
        if (size > most_in_place) many_.assign(size, T{});
    }
    template <class List>
    void assign(const List& list) {
        resize(list.size());
        std::copy(list.begin(), list.end(), begin());
    }

private:
    std::size_t size_ = 0;
    T few_[most_in_place] = {};
    std::vector<T> many_;
};

}  // namespace hardlimit::boxes
