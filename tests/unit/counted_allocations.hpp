// Counts what a thread allocates, for tests of the real-time cycle. It replaces operator new of the whole
// program: include it in one source of a test program.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <new>

namespace headstock {

/// Allocations of the calling thread so far.
inline thread_local std::uint64_t thread_allocations = 0;

inline void* counted_memory(std::size_t size) {
  ++thread_allocations;
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}

}  // namespace headstock

void* operator new(std::size_t size) {
  return headstock::counted_memory(size);
}
void* operator new[](std::size_t size) {
  return headstock::counted_memory(size);
}
void operator delete(void* p) noexcept {
  std::free(p);
}
void operator delete[](void* p) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}
void operator delete[](void* p, std::size_t) noexcept {
  std::free(p);
}
