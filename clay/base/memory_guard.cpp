#include "clay/base/memory_guard.h"

#include <algorithm>
#include <fstream>
#include <new>
#include <string>

#include <fmt/format.h>

#include "clay/base/error.h"

namespace argil {
namespace {

constexpr int64_t kBetweenLooks = int64_t{64} << 20;
constexpr uint64_t kReserveShare = 32;

// The number behind a word that begins a line.
std::optional<uint64_t> numberAfter(const std::filesystem::path& file, const std::string& word) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (line.compare(0, word.size(), word) != 0) continue;
    const size_t at = line.find_first_of("0123456789", word.size());
    if (at == std::string::npos) return std::nullopt;
    try {
      return std::stoull(line.substr(at));
    } catch (const std::exception&) {
      return std::nullopt;
    }
  }
  return std::nullopt;
}

// A control group's, or nothing where it has no limit.
std::optional<uint64_t> roomIn(const std::filesystem::path& group) {
  const auto most = numberAfter(group / "memory.max", ""), now = numberAfter(group / "memory.current", "");
  if (!most || !now) return std::nullopt;
  const uint64_t files = std::min(*now, numberAfter(group / "memory.stat", "inactive_file ").value_or(0));
  const uint64_t used = *now - files;
  return *most > used ? *most - used : 0;
}

MemoryGuard& ownGuard() {
  static MemoryGuard guard([] { return memoryRoom(); });
  return guard;
}

std::atomic<MemoryGuard*> pretended{nullptr};

MemoryGuard& guard() {
  MemoryGuard* const instead = pretended.load();
  return instead ? *instead : ownGuard();
}

}  // namespace

MemoryRoom memoryRoom(const std::filesystem::path& root) {
  MemoryRoom room;
  const auto bytes = [&](const char* word) -> std::optional<uint64_t> {
    const auto kib = numberAfter(root / "proc/meminfo", word);
    return kib ? std::optional(*kib << 10) : std::nullopt;
  };
  room.total = bytes("MemTotal:");
  room.available = bytes("MemAvailable:");
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (line.compare(0, 4, "0::/") != 0) continue;
    // Its own and all above it.
    for (std::filesystem::path group = line.substr(4);; group = group.parent_path()) {
      if (const auto here = roomIn(root / "sys/fs/cgroup" / group))
        room.available = std::min(room.available.value_or(*here), *here);
      if (group.empty()) break;
    }
  }
  return room;
}

std::optional<uint64_t> MemoryGuard::free() const {
  const MemoryRoom room = source_();
  if (!room.available) return std::nullopt;
  const uint64_t reserve = std::max(kLeastReserve, room.total.value_or(0) / kReserveShare);
  return *room.available > reserve ? *room.available - reserve : 0;
}

void MemoryGuard::claim(size_t bytes) {
  const auto wanted = static_cast<int64_t>(std::min<size_t>(bytes, INT64_MAX / 2));
  if (credit_.fetch_sub(wanted) >= wanted) return;
  credit_ = 0;
  const std::optional<uint64_t> left = free();
  if (!left) return;
  if (*left < static_cast<uint64_t>(wanted)) throw std::bad_alloc();
  credit_ = std::min<int64_t>(kBetweenLooks, static_cast<int64_t>(*left - static_cast<uint64_t>(wanted)));
}

void claimMemory(size_t bytes) {
  guard().claim(bytes);
}

void requireMemory(double bytes, std::string_view what, std::string_view instead) {
  const std::optional<uint64_t> left = guard().free();
  if (!left || bytes <= double(*left)) return;
  throw Error(fmt::format("{} would take about {:.3g} GB of memory, and {:.3g} GB are free: {}", what, bytes * 1e-9,
                          double(*left) * 1e-9, instead));
}

PretendedMemory::PretendedMemory(MemoryGuard::Source source) : guard_(std::move(source)) {
  pretended = &guard_;
}

PretendedMemory::~PretendedMemory() {
  pretended = nullptr;
}

}  // namespace argil
