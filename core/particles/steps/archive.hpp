// A state as bytes and back. The same machine, or one of the same kind, reads what it wrote.
#pragma once
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace hardlimit::particles::steps {

class Writer {
public:
    template <class T>
    void operator()(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
    }
    template <class T>
    void operator()(const std::vector<T>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        (*this)(values.size());
        bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    }
    void operator()(const std::string& text) { (*this)(std::vector<char>(text.begin(), text.end())); }
    std::string take() { return std::move(bytes_); }

private:
    std::string bytes_;
};

// Whoever reads asks `good` at the end; values that are not there are left alone.
class Reader {
public:
    explicit Reader(std::string_view bytes) : bytes_(bytes) {}

    template <class T>
    void operator()(T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        if (has(sizeof(T))) take(&value, sizeof(T));
    }
    template <class T>
    void operator()(std::vector<T>& values) {
        std::size_t count = 0;
        (*this)(count);
        if (!good_ || count > bytes_.size() / sizeof(T)) {
            good_ = false;
            return;
        }
        values.resize(count);
        if (count > 0) take(values.data(), count * sizeof(T));
    }
    void operator()(std::string& text) {
        std::vector<char> letters;
        (*this)(letters);
        text.assign(letters.begin(), letters.end());
    }
    bool good() const { return good_; }
    bool ended() const { return good_ && bytes_.empty(); }

private:
    std::string_view bytes_;
    bool good_ = true;

    bool has(std::size_t count) { return good_ = good_ && bytes_.size() >= count; }
    void take(void* to, std::size_t count) {
        std::memcpy(to, bytes_.data(), count);
        bytes_.remove_prefix(count);
    }
};

}  // namespace hardlimit::particles::steps
