// 3MF behind its ZIP: the input is the model part, and after a zero byte a second one, "3D/other.model", put into an
// archive with right checksums.
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/io/mesh_target.h"

namespace {

uint32_t crcOf(std::string_view bytes) {
  static const std::array<uint32_t, 256> kTable = [] {
    std::array<uint32_t, 256> table;
    for (uint32_t i = 0; i < 256; ++i) {
      uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ (value & 1 ? 0xedb88320u : 0);
      table[i] = value;
    }
    return table;
  }();
  uint32_t crc = ~0u;
  for (const char c : bytes) crc = (crc >> 8) ^ kTable[(crc ^ static_cast<unsigned char>(c)) & 0xff];
  return ~crc;
}

class Archive {
 public:
  void add(std::string_view name, std::string_view content) {
    const uint32_t begin = uint32_t(bytes_.size());
    std::string facts;  // What the local header and the table say alike: flags and method 0, no date, then these.
    for (const uint32_t number : {0u, 0u, crcOf(content), uint32_t(content.size()), uint32_t(content.size())})
      little(facts, number, 4);
    little(bytes_, 0x04034b50, 4);
    little(bytes_, 20, 2);
    bytes_ += facts;
    little(bytes_, uint32_t(name.size()), 2);
    little(bytes_, 0, 2);
    bytes_.append(name).append(content);
    little(table_, 0x02014b50, 4);
    little(table_, 20, 2);
    little(table_, 20, 2);
    table_ += facts;
    little(table_, uint32_t(name.size()), 2);
    table_.append(12, '\0');
    little(table_, begin, 4);
    table_.append(name);
    ++parts_;
  }
  std::string whole() {
    std::string all = bytes_ + table_;
    little(all, 0x06054b50, 4);
    little(all, 0, 4);
    little(all, parts_, 2);
    little(all, parts_, 2);
    little(all, uint32_t(table_.size()), 4);
    little(all, uint32_t(bytes_.size()), 4);
    little(all, 0, 2);
    return all;
  }

 private:
  static void little(std::string& to, uint32_t value, int bytes) {
    for (; bytes > 0; --bytes, value >>= 8) to += char(value & 0xff);
  }
  std::string bytes_, table_;
  uint32_t parts_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const size_t end = text.find('\0');
  Archive archive;
  archive.add("_rels/.rels",
              "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship "
              "Id=\"r\" Target=\"/3D/3dmodel.model\" "
              "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>");
  archive.add("3D/3dmodel.model", text.substr(0, end));
  if (end != std::string_view::npos) archive.add("3D/other.model", text.substr(end + 1));
  const std::string whole = archive.whole();
  return argil::tests::readAsModel(reinterpret_cast<const uint8_t*>(whole.data()), whole.size(), "input.3mf");
}
