// Which particle has the next event: a calendar queue (R. Brown, Commun. ACM 31, 1220 (1988)) of bare ids.
//
// Time is cut into bins, a year into as many as there are buckets. A bucket is a chain of cache lines of ids, nothing
// else: an id is put into the bin of its particle's next event and never taken out when that event is superseded. When
// a bin's time comes its ids are looked up; those whose event lies elsewhere by now are dropped, the others are sorted.
// Events beyond the year wait in one list. The width of a bin follows the rate of events: a gas that cools slows
// down by many orders of magnitude.
#pragma once
#include <algorithm>
#include <vector>

#include "../common/particle.hpp"
#include "../common/storage.hpp"

namespace hardlimit::boxes {

struct Due {
    double time;  // [s]
    u32 id;
};

inline constexpr u32 most_in_caches = 20'000;  // particles; of fewer, all lies in the caches of a core

class CalendarQueue {
public:
    // Takes up the events of n particles. Key: time of the next event of an id; Name: what orders simultaneous events.
    template <class Key, class Name>
    void rebuild(u32 n, const Key& key, const Name& name) {
        double earliest = math::infinity;
        for (u32 i = 0; i < n; ++i) earliest = math::min(earliest, key(i));
        clear(n);
        if (!(earliest < math::infinity)) return;
        origin_ = earliest;
        per_time_ = 1.0 / width(key);
        for (u32 i = 0; i < n; ++i) push(i, key(i), name);
    }

    template <class Name>
    void push(u32 id, double time, const Name& name) {
        if (!(time < math::infinity)) return;
        const u64 bin = bin_of(time);
        if (bin <= current_)
            insert(Due{time, id}, name);
        else if (bin < current_ + buckets_.size())
            add(buckets_[bin & mask_], id);
        else
            make_room(far_), far_.push_back(id);
    }

    // The next event, or nullptr. It stays until pop(). loaded() is called where a new bin has been looked up.
    template <class Key, class Name, class Loaded>
    const Due* next(const Key& key, const Name& name, const Loaded& loaded) {
        while (!front_.empty()) {
            if (key(front_.back().id) == front_.back().time) return &front_.back();
            front_.pop_back();  // superseded
        }
        while (held_ > 0 || !far_.empty()) {
            ++current_;
            if (current_ == year_end_) {
                start_year(key);
                if (unfit_) rebuild(n_, key, name);
            }
            load(key, name);
            loaded();
            if (!front_.empty()) return &front_.back();
        }
        return nullptr;
    }
    // The event that next() gave.
    void pop() {
        front_.pop_back();
        ++taken_;
    }

    // f(id) of the event that comes so many after the next one, where it is known.
    template <class F>
    void ahead(std::size_t events, const F& f) const {
        if (events < front_.size()) f(front_[front_.size() - 1 - events].id);
    }

    // What loading the bins after the current one will read.
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
               far_.capacity() * sizeof(u32) + front_.capacity() * sizeof(Due);
    }

private:
    struct alignas(64) Chunk {
        u32 id[15];
        u32 next;  // the full chunk after it
    };
    // Events in a bin, about. What those of a new bin need is fetched when it is entered, all at once: a wait that
    // fewer, larger bins make rarer.
    static constexpr double per_small_bin = 24.0, per_large_bin = 256.0;
    static constexpr u32 none = 0;  // of a bucket: chunk index · 16 + number of ids in it, never 0 with ids
    static constexpr double last_bin = 4e18;

    Records<u32> buckets_;
    Records<Chunk> chunks_;
    u32 free_ = no_particle;
    Records<u32> far_;
    std::vector<Due> front_;  // of the bin whose time it is, latest first
    u64 current_ = 0, year_end_ = 0, mask_ = 0, held_ = 0, taken_ = 0;
    u32 n_ = 0;
    double origin_ = 0.0, per_time_ = 1.0;
    bool unfit_ = false;  // the bins have become far too narrow or too wide for the rate of events

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
        far_.clear();
        front_.clear();
        current_ = held_ = taken_ = 0;
        n_ = n;
        year_end_ = buckets;
        unfit_ = false;
    }

    // Of a bin that holds per_bin() events: a quarter of the particles have theirs before the first quartile of the
    // times.
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

    template <class Name>
    void insert(Due due, const Name& name) {
        const auto after = [&](const Due& a, const Due& b) { return later(a, b, name); };
        front_.insert(std::upper_bound(front_.begin(), front_.end(), due, after), due);
    }
    template <class Name>
    static bool later(const Due& a, const Due& b, const Name& name) {
        return a.time != b.time ? a.time > b.time : name(a.id) > name(b.id);
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
            make_room(chunks_);
            chunks_.push_back({});
            return static_cast<u32>(chunks_.size() - 1);
        }
        const u32 chunk = free_;
        free_ = chunks_[chunk].next;
        return chunk;
    }

    template <class Key, class Name>
    void load(const Key& key, const Name& name) {
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
        sort(name);
    }
    template <class Name>
    void sort(const Name& name) {
        std::sort(front_.begin(), front_.end(),
                  [&](const Due& a, const Due& b) { return later(a, b, name); });
        const auto twice = [](const Due& a, const Due& b) { return a.id == b.id; };
        front_.erase(std::unique(front_.begin(), front_.end(), twice), front_.end());
    }

    // The events that fall into the coming year go from the list to their bins.
    template <class Key>
    void start_year(const Key& key) {
        const double mean = static_cast<double>(taken_) / static_cast<double>(buckets_.size());
        unfit_ = mean > 3.0 * per_bin() || mean < per_bin() / 3.0;
        taken_ = 0;
        year_end_ += buckets_.size();
        std::size_t kept = 0;
        for (const u32 id : far_) {
            const double time = key(id);
            if (!(time < math::infinity)) continue;
            const u64 bin = bin_of(time);
            if (bin < current_) continue;
            if (bin < year_end_)
                add(buckets_[bin & mask_], id);
            else
                far_[kept++] = id;
        }
        far_.resize(kept);
    }
};

}  // namespace hardlimit::boxes
