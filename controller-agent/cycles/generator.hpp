// A sequence made one element at a time by a coroutine: `co_yield` hands out an element, the function goes on
// when the next one is asked for. One owner, one thread.
#pragma once

#include <coroutine>
#include <exception>
#include <utility>

namespace headstock::cycles {

template <typename T>
class Generator {
 public:
  struct promise_type {
    T value{};
    Generator get_return_object() {
      return Generator(std::coroutine_handle<promise_type>::from_promise(*this));
    }
    std::suspend_always initial_suspend() noexcept { return {}; }
    std::suspend_always final_suspend() noexcept { return {}; }
    std::suspend_always yield_value(const T& made) {
      value = made;
      return {};
    }
    void return_void() {}
    void unhandled_exception() { std::terminate(); }  // planners throw nothing
  };

  Generator() = default;
  explicit Generator(std::coroutine_handle<promise_type> handle) : handle_(handle) {}
  Generator(Generator&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  Generator& operator=(Generator&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  Generator(const Generator&) = delete;
  Generator& operator=(const Generator&) = delete;
  ~Generator() {
    if (handle_) handle_.destroy();
  }

  /// @return false when the sequence is over.
  bool next(T& out) {
    if (!handle_ || handle_.done()) return false;
    handle_.resume();
    if (handle_.done()) return false;
    out = handle_.promise().value;
    return true;
  }

 private:
  std::coroutine_handle<promise_type> handle_;
};

}  // namespace headstock::cycles
