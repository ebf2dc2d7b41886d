#include "daemon/realtime/stream_memory.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <new>
#include <type_traits>

namespace truepose::daemon {
namespace {

constexpr std::uint64_t kMagic = 0x74727565706f7301;  // changes with the layout

static_assert(std::is_trivially_copyable_v<StreamMemory::Record>);

struct Slot {
  std::uint64_t number = 0;  // of the record; 0 = none
  StreamMemory::Record record;
  std::uint64_t check = 0;
};

/// FNV-1a over number and record.
std::uint64_t check_of(const Slot& slot) noexcept {
  std::array<unsigned char, offsetof(Slot, check)> bytes;
  std::memcpy(bytes.data(), &slot, bytes.size());
  std::uint64_t sum = 14695981039346656037u;
  for (const unsigned char byte : bytes) sum = (sum ^ byte) * 1099511628211u;
  return sum;
}

bool plausible(const StreamMemory::Record& record) noexcept {
  for (std::size_t i = 0; i < record.min_rad.size(); ++i) {
    if (!std::isfinite(record.min_rad[i]) || !std::isfinite(record.max_rad[i]) ||
        !std::isfinite(record.sent_rad[i]) || record.min_rad[i] > record.max_rad[i])
      return false;
  }
  return record.port <= 65535;
}

}  // namespace

struct StreamMemory::Page {
  std::uint64_t magic;
  std::array<Slot, 2> slots;
};

StreamMemory::StreamMemory(Page* page) : page_{page} {
  for (std::size_t i = 0; i < page_->slots.size(); ++i) {
    const Slot& slot = page_->slots[i];
    if (slot.number <= number_ || slot.check != check_of(slot)) continue;
    number_ = slot.number;
    newest_ = i;
  }
}

std::expected<std::unique_ptr<StreamMemory>, drivers::StartFailure> StreamMemory::open(
    const std::filesystem::path& file) {
  const auto failed = [&](const char* what, int error) {
    const bool full = error == ENOSPC || error == EDQUOT;
    return std::unexpected(
        drivers::StartFailure{file.string() + ": " + what + ": " + std::strerror(error), full});
  };
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  if (descriptor < 0) return failed("cannot be opened", errno);
  // With room for all of it: what a full file system has no page for would be a SIGBUS when it is written to.
  if (const int error = ::posix_fallocate(descriptor, 0, sizeof(Page)); error != 0) {
    ::close(descriptor);
    return failed("cannot be made as large as a page", error);
  }
  void* const mapped = ::mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  const int error = errno;
  ::close(descriptor);
  if (mapped == MAP_FAILED) return failed("cannot be mapped", error);
  auto* const page = static_cast<Page*>(mapped);
  if (page->magic != kMagic) *page = Page{.magic = kMagic, .slots = {}};
  return std::unique_ptr<StreamMemory>(new StreamMemory(page));
}

std::unique_ptr<StreamMemory> StreamMemory::in_process() {
  void* const mapped =
      ::mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED) throw std::bad_alloc{};
  return std::unique_ptr<StreamMemory>(new StreamMemory(new (mapped) Page{.magic = kMagic, .slots = {}}));
}

StreamMemory::~StreamMemory() { ::munmap(page_, sizeof(Page)); }

std::optional<StreamMemory::Record> StreamMemory::last() const noexcept {
  if (number_ == 0 || !plausible(page_->slots[newest_].record)) return std::nullopt;
  return page_->slots[newest_].record;
}

void StreamMemory::keep(const Record& record) noexcept {
  newest_ = 1 - newest_;
  Slot slot{.number = ++number_, .record = record};
  slot.check = check_of(slot);
  page_->slots[newest_] = slot;
  // Before the reply leaves: whatever ends this process, the page is not behind what was sent.
  std::atomic_signal_fence(std::memory_order_seq_cst);
}

}  // namespace truepose::daemon
