#include "daemon/recorder/byte_queue.hpp"

#include <algorithm>

namespace truepose::daemon {

bool ByteQueue::push(std::initializer_list<std::string_view> parts) noexcept {
  Size size = 0;
  for (const std::string_view part : parts) size += static_cast<Size>(part.size());
  const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
  if (tail - head_.load(std::memory_order_acquire) + sizeof size + size > bytes_.size()) {
    dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    return false;
  }
  std::uint64_t at = put(tail, {reinterpret_cast<const char*>(&size), sizeof size});
  for (const std::string_view part : parts) at = put(at, part);
  tail_.store(at, std::memory_order_release);
  return true;
}

bool ByteQueue::pop(std::string& text) {
  const std::uint64_t head = head_.load(std::memory_order_relaxed);
  if (head == tail_.load(std::memory_order_acquire)) return false;
  Size size = 0;
  get(head, reinterpret_cast<char*>(&size), sizeof size);
  text.resize(size);
  get(head + sizeof size, text.data(), size);
  head_.store(head + sizeof size + size, std::memory_order_release);
  return true;
}

std::uint64_t ByteQueue::put(std::uint64_t at, std::string_view part) noexcept {
  const std::size_t begin = at % bytes_.size();
  const std::size_t first = std::min(part.size(), bytes_.size() - begin);
  std::copy_n(part.data(), first, bytes_.data() + begin);
  std::copy(part.begin() + static_cast<std::ptrdiff_t>(first), part.end(), bytes_.data());
  return at + part.size();
}

void ByteQueue::get(std::uint64_t at, char* to, std::size_t size) const noexcept {
  const std::size_t begin = at % bytes_.size();
  const std::size_t first = std::min(size, bytes_.size() - begin);
  std::copy_n(bytes_.data() + begin, first, to);
  std::copy_n(bytes_.data(), size - first, to + first);
}

}  // namespace truepose::daemon
