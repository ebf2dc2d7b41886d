#include "daemon/recorder/ring.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

namespace truepose::daemon {

struct Ring::Slot {
  std::uint64_t number;  // of its block; 0 = none
  std::int64_t begin_ns;
  std::uint32_t size, checksum;
  std::array<char, kSlotBytes> texts;

  bool whole() const {
    if (number == 0 || size == 0 || size > texts.size()) return false;
    boost::crc_32_type sum;
    sum.process_bytes(texts.data(), size);
    return sum.checksum() == checksum;
  }
};

namespace {

void* map(int descriptor, std::size_t bytes, int flags) {
  return ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, flags, descriptor, 0);
}

/// Maps a file, which `prepare` makes ready. @return its pages and their size, or one sentence
std::expected<std::pair<void*, std::size_t>, std::string> map_file(
    const std::filesystem::path& file, int flags, int (*prepare)(int file, std::size_t bytes),
    std::size_t bytes) {
  const auto failed = [&](int error) {
    return std::unexpected(file.string() + ": cannot be used for the recording: " + std::strerror(error));
  };
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | flags, 0600);
  if (descriptor < 0) return failed(errno);
  int error = prepare(descriptor, bytes);
  struct stat about {};
  if (error == 0 && ::fstat(descriptor, &about) != 0) error = errno;
  const auto size = static_cast<std::size_t>(about.st_size);
  void* const mapped = error == 0 ? map(descriptor, std::max<std::size_t>(size, 1), MAP_SHARED) : MAP_FAILED;
  if (error == 0 && mapped == MAP_FAILED) error = errno;
  ::close(descriptor);
  if (error != 0) return failed(error);
  return std::pair{mapped, size};
}

}  // namespace

Ring::Ring(void* mapped, std::size_t mapped_bytes)
    : mapped_{mapped}, mapped_bytes_{mapped_bytes}, slots_{mapped_bytes / sizeof(Slot)} {}

Ring::~Ring() { ::munmap(mapped_, mapped_bytes_); }

std::expected<std::unique_ptr<Ring>, std::string> Ring::create(const std::filesystem::path& file,
                                                               std::size_t bytes) {
  const auto prepare = [](int descriptor, std::size_t size) {
    return ::posix_fallocate(descriptor, 0, static_cast<off_t>(size));
  };
  const auto mapped = map_file(file, O_CREAT | O_TRUNC, prepare, bytes);
  if (!mapped) return std::unexpected(mapped.error());
  return std::unique_ptr<Ring>(new Ring(mapped->first, mapped->second));
}

std::unique_ptr<Ring> Ring::in_process(std::size_t bytes) {
  void* const mapped = map(-1, bytes, MAP_PRIVATE | MAP_ANONYMOUS);
  if (mapped == MAP_FAILED) throw std::bad_alloc{};
  return std::unique_ptr<Ring>(new Ring(mapped, bytes));
}

std::expected<std::unique_ptr<Ring>, std::string> Ring::open(const std::filesystem::path& file) {
  const auto as_it_is = [](int, std::size_t) { return 0; };
  const auto mapped = map_file(file, 0, as_it_is, 0);
  if (!mapped) return std::unexpected(mapped.error());
  return std::unique_ptr<Ring>(new Ring(mapped->first, mapped->second));
}

Ring::Slot& Ring::slot(std::uint64_t number) const { return static_cast<Slot*>(mapped_)[number % slots_]; }

void Ring::append(std::int64_t time_ns, std::string_view text) {
  if (number_ == 0) begin_slot(time_ns);
  if (slot(number_).size + fresh_.size() + text.size() > kSlotBytes) {
    settle();
    begin_slot(time_ns);
  }
  fresh_ += text;
}

void Ring::begin_slot(std::int64_t time_ns) {
  Slot& next = slot(++number_);
  bytes_ -= next.size;
  next.number = 0;
  next.size = next.checksum = 0;
  next.begin_ns = time_ns;
  checksum_.reset();
}

void Ring::settle() {
  if (fresh_.empty()) return;
  Slot& now = slot(number_);
  std::ranges::copy(fresh_, now.texts.begin() + now.size);
  checksum_.process_bytes(fresh_.data(), fresh_.size());
  now.checksum = checksum_.checksum();
  now.size += static_cast<std::uint32_t>(fresh_.size());
  now.number = number_;
  bytes_ += fresh_.size();
  fresh_.clear();
}

std::vector<Ring::Block> Ring::blocks() const {
  std::vector<const Slot*> whole;
  for (std::size_t i = 0; i < slots_; ++i) {
    if (slot(i).whole()) whole.push_back(&slot(i));
  }
  std::ranges::sort(whole, {}, &Slot::number);
  std::vector<Block> blocks;
  for (const Slot* each : whole) blocks.push_back({each->begin_ns, {each->texts.data(), each->size}});
  return blocks;
}

std::optional<std::int64_t> Ring::begin_ns() const {
  if (number_ == 0) return std::nullopt;
  const std::uint64_t oldest = number_ >= slots_ ? number_ - slots_ + 1 : 1;
  return slot(oldest).begin_ns;
}

}  // namespace truepose::daemon
