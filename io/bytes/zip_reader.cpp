#include "io/bytes/zip_reader.h"

#include <libdeflate.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <numeric>
#include <span>

#include "io/bytes/unpack_limit.h"

namespace argil::io {

namespace {

constexpr uint32_t kLocalHeader = 0x04034b50, kEntry = 0x02014b50, kEnd = 0x06054b50, kEnd64 = 0x06064b50,
                   kEnd64Place = 0x07064b50;
constexpr uint64_t kLocalHeaderBytes = 30, kEntryBytes = 46, kEndBytes = 22, kEnd64Bytes = 56, kEnd64PlaceBytes = 20;
constexpr uint16_t kStored = 0, kDeflated = 8;
constexpr uint16_t kEncrypted = 1;
constexpr uint32_t kElsewhere = 0xffffffff;  ///< Stands where the ZIP64 field has the number.
constexpr uint16_t kZip64Field = 1;
/// Deflate codes 258 bytes in 2 bits at best.
constexpr uint64_t kDeflateRatio = 1032;
constexpr uint64_t kMostTogether = 2 * kMostUnpacked;

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
  return result;
}

/// Some programs write '\'; a path that leaves its folder is no name.
std::string cleanName(const std::string& archive, std::string_view raw) {
  std::string name(raw);
  std::replace(name.begin(), name.end(), '\\', '/');
  const auto bad = [&](const char* why) {
    fail(archive, "holds a part named " + shown(raw) + ", " + why + "; it may be an attack, do not use it");
  };
  if (name.empty()) bad("which is no name");
  if (name.front() == '/') bad("which is an absolute path");
  if (name.find('\0') != std::string::npos) bad("which is no name");
  for (size_t begin = 0; begin <= name.size();) {
    const size_t end = std::min(name.find('/', begin), name.size());
    const std::string_view segment = std::string_view(name).substr(begin, end - begin);
    if (segment == "." || segment == "..") bad("which leads elsewhere");
    begin = end + 1;
  }
  return name;
}

}  // namespace

ZipReader::ZipReader(const Input& input) : input_(input) {
  readTable();
}

void ZipReader::damaged(const std::string& what) const {
  fail(input_.name, "is damaged or was cut off: " + what + "; export it again");
}

// Callers have checked that the bytes are there.
uint64_t ZipReader::little(uint64_t at, int bytes) const {
  uint64_t value = 0;
  for (int i = bytes - 1; i >= 0; --i)
    value = value << 8 | std::to_integer<uint64_t>(input_.bytes[at + static_cast<uint64_t>(i)]);
  return value;
}

void ZipReader::readEnd(uint64_t& entries, uint64_t& begin, uint64_t& size) const {
  const uint64_t all = input_.bytes.size();
  constexpr uint64_t kLongestComment = 0xffff;
  uint64_t end = all;
  for (uint64_t back = kEndBytes; back <= std::min(all, kEndBytes + kLongestComment); ++back) {
    const uint64_t at = all - back;
    if (little(at, 4) == kEnd && little(at + 20, 2) == back - kEndBytes) {
      end = at;
      break;
    }
  }
  if (end == all) damaged("its archive has no end");
  entries = little(end + 10, 2);
  size = little(end + 12, 4);
  begin = little(end + 16, 4);
  if (little(end + 4, 2) != little(end + 6, 2) || little(end + 8, 2) != entries)
    fail(input_.name, "is one of several volumes; join them first");
  const bool wide = entries == 0xffff || size == kElsewhere || begin == kElsewhere;
  uint64_t tableEnd = end;
  if (wide && end >= kEnd64PlaceBytes && little(end - kEnd64PlaceBytes, 4) == kEnd64Place) {
    const uint64_t at = little(end - kEnd64PlaceBytes + 8, 8);
    if (at > end - kEnd64PlaceBytes || end - kEnd64PlaceBytes - at < kEnd64Bytes || little(at, 4) != kEnd64)
      damaged("its ZIP64 end is not where it should be");
    entries = little(at + 32, 8);
    size = little(at + 40, 8);
    begin = little(at + 48, 8);
    tableEnd = at;
  }
  if (begin > tableEnd || size > tableEnd - begin) damaged("its table of parts lies outside");
  if (entries > size / kEntryBytes) damaged("its table of parts is shorter than it says");
}

void ZipReader::readTable() {
  uint64_t entries = 0, at = 0, size = 0;
  readEnd(entries, at, size);
  const uint64_t end = at + size;
  parts_.reserve(entries);
  uint64_t together = 0;
  for (uint64_t i = 0; i < entries; ++i) {
    at = readEntry(at, end);
    together += std::min(parts_.back().size, kMostTogether);
  }
  // Parts of their own may be dense; all of them are not, but in an archive that is to fill the memory.
  if (isTooDense(together,
                 input_.packed == 0 ? input_.bytes.size() : std::min<uint64_t>(input_.packed, input_.bytes.size())))
    fail(input_.name, "says that it unpacks to " + std::to_string(together >> 20) + " MiB, more than " +
                          std::to_string(kMostUnpackRatio) +
                          " times its size, as no model does; it may be an attack, or unpack it first");
  byName_.resize(parts_.size());
  std::iota(byName_.begin(), byName_.end(), 0u);
  std::vector<std::string> names;
  for (const Part& part : parts_) names.push_back(lower(part.name));
  std::sort(byName_.begin(), byName_.end(), [&](uint32_t a, uint32_t b) { return names[a] < names[b]; });
  for (size_t i = 1; i < byName_.size(); ++i) {
    if (names[byName_[i]] == names[byName_[i - 1]])
      damaged("it holds two parts named " + shown(parts_[byName_[i]].name));
  }
}

uint64_t ZipReader::readEntry(uint64_t at, uint64_t end) {
  if (end - at < kEntryBytes || little(at, 4) != kEntry) damaged("its table of parts is broken");
  Part part;
  part.flags = static_cast<uint16_t>(little(at + 8, 2));
  part.method = static_cast<uint16_t>(little(at + 10, 2));
  part.crc = static_cast<uint32_t>(little(at + 16, 4));
  part.packed = little(at + 20, 4);
  part.size = little(at + 24, 4);
  const uint64_t nameBytes = little(at + 28, 2), extraBytes = little(at + 30, 2), commentBytes = little(at + 32, 2);
  part.header = little(at + 42, 4);
  at += kEntryBytes;
  if (end - at < nameBytes + extraBytes + commentBytes) damaged("its table of parts is broken");
  part.name = cleanName(input_.name, input_.text().substr(at, nameBytes));
  at += nameBytes;
  const uint64_t next = at + extraBytes + commentBytes;
  for (uint64_t left = extraBytes; left >= 4;) {
    const uint64_t kind = little(at, 2), bytes = little(at + 2, 2);
    if (bytes > left - 4) damaged("a field of " + shown(part.name) + " is too long");
    if (kind == kZip64Field) {
      // Only the numbers that did not fit stand here, in this order.
      uint64_t from = at + 4;
      for (uint64_t* number : {&part.size, &part.packed, &part.header}) {
        if (*number != kElsewhere) continue;
        if (from + 8 > at + 4 + bytes) damaged("the ZIP64 field of " + shown(part.name) + " is too short");
        *number = little(from, 8);
        from += 8;
      }
    }
    at += 4 + bytes;
    left -= 4 + bytes;
  }
  parts_.push_back(std::move(part));
  return next;
}

const ZipReader::Part* ZipReader::find(std::string_view name) const {
  const std::string wanted = lower(name);
  const auto found =
      std::lower_bound(byName_.begin(), byName_.end(), wanted,
                       [&](uint32_t part, const std::string& text) { return lower(parts_[part].name) < text; });
  return found != byName_.end() && lower(parts_[*found].name) == wanted ? &parts_[*found] : nullptr;
}

FileBytes ZipReader::read(const Part& part) {
  const uint64_t all = input_.bytes.size();
  const std::string name = shown(part.name);
  if (part.flags & kEncrypted) fail(input_.name, "its part " + name + " is encrypted; save it without a password");
  if (part.method != kStored && part.method != kDeflated) {
    fail(input_.name, "its part " + name + " is packed by method " + std::to_string(part.method) +
                          ", which cannot be read; pack it with deflate");
  }
  if (part.header > all || all - part.header < kLocalHeaderBytes || little(part.header, 4) != kLocalHeader)
    damaged("part " + name + " is not where it should be");
  const uint64_t nameBytes = little(part.header + 26, 2), extraBytes = little(part.header + 28, 2);
  const uint64_t data = part.header + kLocalHeaderBytes + nameBytes + extraBytes;
  if (data > all || part.packed > all - data) damaged("part " + name + " reaches beyond the end");
  // Two programs must not see two different parts here.
  if (little(part.header + 8, 2) != part.method ||
      cleanName(input_.name, input_.text().substr(part.header + kLocalHeaderBytes, nameBytes)) != part.name) {
    damaged("part " + name + " contradicts the table");
  }
  const bool stored = part.method == kStored;
  if (stored ? part.size != part.packed : part.size / kDeflateRatio > part.packed)
    damaged("part " + name + " cannot have as many bytes as it says");
  if (part.size > kMostUnpacked || part.size > kMostTogether - unpacked_ || isTooDense(part.size, part.packed)) {
    fail(input_.name, "its part " + name + " unpacks to " + std::to_string(part.size) +
                          " bytes, more than is read; reduce the model or export it in another format");
  }
  requireMemory(input_.name, part.size);
  unpacked_ += part.size;

  FileBytes result;
  result.size = part.size;
  try {
    result.data = std::make_unique_for_overwrite<std::byte[]>(std::max<uint64_t>(part.size, 1));
  } catch (const std::bad_alloc&) {
    fail(input_.name, "its part " + name + " does not fit into memory (" + std::to_string(part.size) +
                          " bytes); reduce the model first");
  }
  const std::byte* from = input_.bytes.data() + data;
  if (stored) {
    std::memcpy(result.data.get(), from, part.size);
  } else {
    const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> unpacker(
        libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
    if (unpacker == nullptr) throw std::bad_alloc();
    size_t used = 0, made = 0;
    const auto outcome =
        libdeflate_deflate_decompress_ex(unpacker.get(), from, part.packed, result.data.get(), part.size, &used, &made);
    if (outcome != LIBDEFLATE_SUCCESS || used != part.packed || made != part.size)
      damaged("part " + name + " cannot be unpacked");
  }
  if (libdeflate_crc32(0, result.data.get(), part.size) != part.crc)
    damaged("the checksum of part " + name + " is wrong");
  return result;
}

}  // namespace argil::io
