// What the C++ library would otherwise bring along to report fatal errors (and with it imports from a host): nothing.
// Out of memory or a broken precondition stops the module; the page shows that as an error.
#include <__verbose_abort>
#include <cstdlib>
#include <new>

void* operator new(std::size_t size) {
    void* p = std::malloc(size ? size : 1);
    if (!p) __builtin_trap();
    return p;
}
void* operator new[](std::size_t size) { return operator new(size); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return std::malloc(size ? size : 1); }
void* operator new(std::size_t size, std::align_val_t alignment) {
    const std::size_t unit = static_cast<std::size_t>(alignment);
    void* p = std::aligned_alloc(unit, (size + unit - 1) / unit * unit);
    if (!p) __builtin_trap();
    return p;
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }

void std::__libcpp_verbose_abort(const char*, ...) { __builtin_trap(); }

extern "C" void __cxa_pure_virtual() { __builtin_trap(); }
extern "C" void abort_message(const char*, ...) { __builtin_trap(); }
