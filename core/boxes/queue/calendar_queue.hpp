// Event queue: a calendar queue (R. Brown, Commun. ACM 31, 1220 (1988)) of particle ids.
//
// Time is divided into bins; a year has as many bins as there are buckets. A bucket is a linked list of cache lines
// that hold only ids. An id is put into the bin of its particle's next event, and stays there when that event is
// superseded. When a bin becomes current, ids whose event has moved are dropped and the others are sorted by time.
// Events beyond the year wait in one list. The bin width follows the event rate, since a cooling gas slows down by many
// orders of magnitude.
#pragma once
#include <algorithm>
#include <vector>

#include "../common/particle.hpp"
#include "../common/storage.hpp"

namespace hardlimit::boxes {

struct QueuedEvent {
    double time;  // [s]
    u32 id;
};

inline constexpr u32 most_in_caches = 20'000;  // particles whose data fit into the caches of a core

class CalendarQueue {
public:
    // Rebuilds the queue from the events of n particles. Key: time of the next event of an id; TieBreak: orders
    // simultaneous events.
    template <class Key, class TieBreak>
    void rebuild(u32 n, const Key& key, const TieBreak& tie_break) {
        double earliest = math::infinity;
        for (u32 i = 0; i < n; ++i) earliest = math::min(earliest, key(i));
        clear(n);
        if (!(earliest < math::infinity)) return;
        origin_ = earliest;
        per_time_ = 1.0 / width(key);
        for (u32 i = 0; i < n; ++i) push(i, key(i), tie_break);
    }

    template <class TieBreak>
    void push(u32 id, double time, const TieBreak& tie_break) {
        if (!(time < math::infinity)) return;
        const u64 bin = bin_of(time);
        if (bin <= current_)
            insert(QueuedEvent{time, id}, tie_break);
        else if (bin < current_ + buckets_.size())
            add(buckets_[bin & mask_], id);
        else
            reserve_one(overflow_), overflow_.push_back(id);
    }

    // The next event, or nullptr. It stays until pop(). Calls loaded() after loading a bin.
    template <class Key, class TieBreak, class Loaded>
    const QueuedEvent* next(const Key& key, const TieBreak& tie_break, const Loaded& loaded) {
        while (!front_.empty()) {
            if (key(front_.back().id) == front_.back().time) return &front_.back();
            front_.pop_back();  // superseded
        }
        while (held_ > 0 || !overflow_.empty()) {
            ++current_;
            if (current_ == year_end_) {
                start_year(key);
                if (needs_resize_) rebuild(n_, key, tie_break);
            }
            load(key, tie_break);
            loaded();
            if (!front_.empty()) return &front_.back();
        }
        return nullptr;
    }
    // Removes the event that next() returned.
    void pop() {
        front_.pop_back();
        ++taken_;
    }

    // Calls f(id) for the event this many places after the next one, if it is in the current bin.
    template <class F>
    void ahead(std::size_t events, const F& f) const {
        if (events < front_.size()) f(front_[front_.size() - 1 - events].id);
    }

    // Calls fetch(id) for all ids that loading the next bin will read.
    template <class Fetch>
    void fetch_next(const Fetch& fetch) const {
        for (u32 bucket = buckets_[(current_ + 1) & mask_]; bucket != none;
             bucket = chunks_[bucket >> 4].next)
            for (u32 k = 0; k < (bucket & 15u); ++k) fetch(chunks_[bucket >> 4].id[k]);
        const u32 later = buckets_[(current_ + 2) & mask_];
        if (later != none) prefetch(&chunks_[later >> 4]);
    }

    std::size_t bytes() const {
        return buckets_.capacity() * sizeof(u32) + chunks_.capacity() * sizeof(Chunk) +
               overflow_.capacity() * sizeof(u32) + front_.capacity() * sizeof(QueuedEvent);
    }

private:
    struct alignas(64) Chunk {
        u32 id[15];
        u32 next;  // next full chunk
    };
    // Target number of events per bin. Loading a bin waits for the data of its first events, which is rarer with large
    // bins.
    static constexpr double per_small_bin = 24.0, per_large_bin = 256.0;
    static constexpr u32 none = 0;  // empty bucket; otherwise: chunk index · 16 + number of ids in the chunk
    static constexpr double last_bin = 4e18;

    Records<u32> buckets_;
    Records<Chunk> chunks_;
    u32 free_ = no_particle;
    Records<u32> overflow_;
    std::vector<QueuedEvent> front_;  // events of the current bin, latest first
    u64 current_ = 0, year_end_ = 0, mask_ = 0, held_ = 0, taken_ = 0;
    u32 n_ = 0;
    double origin_ = 0.0, per_time_ = 1.0;
    bool needs_resize_ = false;  // whether bins are far too narrow or too wide for the rate of events

    double per_bin() const { return n_ > most_in_caches ? per_large_bin : per_small_bin; }
    u64 bin_of(double time) const {
        return static_cast<u64>(math::min(math::max((time - origin_) * per_time_, 0.0), last_bin));
    }

    void clear(u32 n) {
        std::size_t buckets = 64;
        while (buckets < n / 8) buckets *= 2;
        buckets_.assign(buckets, none);
        mask_ = buckets - 1;
        chunks_.clear();
        free_ = no_particle;
        overflow_.clear();
        front_.clear();
        current_ = held_ = taken_ = 0;
        n_ = n;
        year_end_ = buckets;
        needs_resize_ = false;
    }

    // Width of a bin with per_bin() events, estimated from the first quartile of the event times.
    template <class Key>
    double width(const Key& key) const {
        std::vector<double> sample;
        const u32 stride = std::max(1u, n_ / 4096u);
        for (u32 i = 0; i < n_; i += stride)
            if (key(i) < math::infinity) sample.push_back(key(i) - origin_);
        std::sort(sample.begin(), sample.end());
        const double finite = static_cast<double>(sample.size()) * stride;
        for (std::size_t at = sample.size() / 4; at < sample.size(); ++at)
            if (sample[at] > 0.0) {
                const double share = (static_cast<double>(at) + 1.0) / static_cast<double>(sample.size());
                return math::max(per_bin() * sample[at] / (share * finite), 1e-300);
            }
        return 1.0;
    }

    template <class TieBreak>
    void insert(QueuedEvent due, const TieBreak& tie_break) {
        const auto after = [&](const QueuedEvent& a, const QueuedEvent& b) { return later(a, b, tie_break); };
        front_.insert(std::upper_bound(front_.begin(), front_.end(), due, after), due);
    }
    template <class TieBreak>
    static bool later(const QueuedEvent& a, const QueuedEvent& b, const TieBreak& tie_break) {
        return a.time != b.time ? a.time > b.time : tie_break(a.id) > tie_break(b.id);
    }

    void add(u32& bucket, u32 id) {
        u32 held = bucket & 15u;
        if (held == 0 || held == 15) {
            const u32 full = bucket;
            bucket = new_chunk() << 4;
            chunks_[bucket >> 4].next = full;
            held = 0;
        }
        chunks_[bucket >> 4].id[held] = id;
        ++bucket;
        ++held_;
    }
    u32 new_chunk() {
        if (free_ == no_particle) {
            reserve_one(chunks_);
            chunks_.push_back({});
            return static_cast<u32>(chunks_.size() - 1);
        }
        const u32 chunk = free_;
        free_ = chunks_[chunk].next;
        return chunk;
    }

    template <class Key, class TieBreak>
    void load(const Key& key, const TieBreak& tie_break) {
        u32 bucket = buckets_[current_ & mask_];
        if (bucket == none) return;
        buckets_[current_ & mask_] = none;
        while (bucket != none) {
            Chunk& chunk = chunks_[bucket >> 4];
            const u32 held = bucket & 15u;
            for (u32 k = 0; k < held; ++k) {
                const double time = key(chunk.id[k]);
                if (time < math::infinity && bin_of(time) == current_) front_.push_back({time, chunk.id[k]});
            }
            held_ -= held;
            const u32 after = chunk.next;
            chunk.next = free_;
            free_ = bucket >> 4;
            bucket = after;
        }
        sort(tie_break);
    }
    template <class TieBreak>
    void sort(const TieBreak& tie_break) {
        std::sort(front_.begin(), front_.end(),
                  [&](const QueuedEvent& a, const QueuedEvent& b) { return later(a, b, tie_break); });
        const auto twice = [](const QueuedEvent& a, const QueuedEvent& b) { return a.id == b.id; };
        front_.erase(std::unique(front_.begin(), front_.end(), twice), front_.end());
    }

    // Moves the events of the new year from the list to their bins.
    template <class Key>
    void start_year(const Key& key) {
        const double mean = static_cast<double>(taken_) / static_cast<double>(buckets_.size());
        needs_resize_ = mean > 3.0 * per_bin() || mean < per_bin() / 3.0;
        taken_ = 0;
        year_end_ += buckets_.size();
        std::size_t kept = 0;
        for (const u32 id : overflow_) {
            const double time = key(id);
            if (!(time < math::infinity)) continue;
            const u64 bin = bin_of(time);
            if (bin < current_) continue;
            if (bin < year_end_)
                add(buckets_[bin & mask_], id);
            else
                overflow_[kept++] = id;
        }
        overflow_.resize(kept);
    }
};

}  // namespace hardlimit::boxes
