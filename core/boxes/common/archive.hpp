// Binary checkpoints of a run. A checkpoint holds the whole state, so a loaded run continues bit for bit.
#pragma once
#include <cstring>
#include <string_view>
#include <type_traits>
#include <vector>

#include "../../base/portable.hpp"

namespace hardlimit::boxes {

inline constexpr char archive_magic[16] = "hardlimit box E";

// Detects damaged files: FNV-1a over words of eight bytes.
HL_FN u64 checksum(const char* data, std::size_t n) {
    u64 sum = 0xcbf29ce484222325ULL;
    for (std::size_t i = 0; i < n; i += 8) {
        u64 word = 0;
        std::memcpy(&word, data + i, n - i < 8 ? n - i : 8);
        sum = (sum ^ word) * 0x100000001b3ULL;
        sum ^= sum >> 29;
    }
    return sum;
}

class Writer {
public:
    // `engine`: name of the engine, stored first.
    explicit Writer(std::string_view engine) : bytes_(archive_magic, archive_magic + sizeof archive_magic) {
        (*this)(std::vector<char>(engine.begin(), engine.end()));
    }

    template <class T>
    void operator()(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        append(&value, sizeof value);
    }
    template <class T, class A>
    void operator()(const std::vector<T, A>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        (*this)(static_cast<u64>(values.size()));
        append(values.data(), values.size() * sizeof(T));
    }
    std::vector<char> finish() {
        (*this)(checksum(bytes_.data(), bytes_.size()));
        return std::move(bytes_);
    }

private:
    std::vector<char> bytes_;

    void append(const void* data, std::size_t n) {
        const std::size_t at = bytes_.size();
        bytes_.resize(at + n);
        if (n > 0) std::memcpy(bytes_.data() + at, data, n);
    }
};

// Reads a checkpoint, never beyond its end. whole() validates it before reading; failed() tells afterwards whether the
// data were too short.
class Reader {
public:
    Reader(const char* data, std::size_t n) : data_(data), n_(n) {}

    // Whether this is a complete, undamaged checkpoint of this engine.
    bool whole(std::string_view engine) {
        if (n_ < sizeof archive_magic + 8 || std::memcmp(data_, archive_magic, sizeof archive_magic) != 0)
            return false;
        u64 sum;
        std::memcpy(&sum, data_ + n_ - 8, 8);
        n_ -= 8;
        at_ = sizeof archive_magic;
        if (sum != checksum(data_, n_)) return false;
        std::vector<char> found;
        (*this)(found);
        return !failed_ && std::string_view(found.data(), found.size()) == engine;
    }
    bool failed() const { return failed_; }

    template <class T>
    void operator()(T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        take(&value, sizeof value);
    }
    template <class T, class A>
    void operator()(std::vector<T, A>& values) {
        u64 n = 0;
        (*this)(n);
        failed_ = failed_ || n > (n_ - at_) / sizeof(T);
        if (failed_) return;
        values.resize(n);
        take(values.data(), n * sizeof(T));
    }

private:
    const char* data_;
    std::size_t n_, at_ = 0;
    bool failed_ = false;

    void take(void* to, std::size_t n) {
        failed_ = failed_ || n > n_ - at_;
        if (failed_ || n == 0) return;
        std::memcpy(to, data_ + at_, n);
        at_ += n;
    }
};

}  // namespace hardlimit::boxes
