#pragma once
// A .gltf or .glb file opened: its JSON, its buffers, numbers through its accessors. Nothing that the file says is
// believed.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace argil::io::reader {

class GltfFile {
 public:
  using Json = nlohmann::json;

  /// Throws Error: no JSON, no glTF 2, chunks that are cut off.
  explicit GltfFile(const std::filesystem::path& file);

  [[nodiscard]] bool binary() const { return binary_; }
  [[nodiscard]] const Json& root() const { return root_; }

  /// The list of that name at the root; an empty one when there is none.
  [[nodiscard]] const Json& list(const char* name) const;
  /// An object in it. Throws Error when the index is out of range.
  [[nodiscard]] const Json& item(const char* list, uint64_t index) const;

  // Members of an object. Throw Error for one of another type; an index must be there unless it is optional.
  [[nodiscard]] static uint64_t index(const Json& object, const char* key);
  [[nodiscard]] static std::optional<uint64_t> optionalIndex(const Json& object, const char* key);
  [[nodiscard]] static std::string text(const Json& object, const char* key);
  /// Finite numbers, exactly `count`; empty when there are none.
  [[nodiscard]] static std::vector<double> numbers(const Json& object, const char* key, size_t count);
  /// A member that is an object or an array; null when there is none.
  [[nodiscard]] static const Json& member(const Json& object, const char* key);

  /// The bytes of a buffer view; its buffer is read when it is first asked for, from the folder of the file and below
  /// it only.
  [[nodiscard]] std::span<const unsigned char> view(uint64_t index);
  /// All values of an accessor of 3 (or 3 to 4) components, sparse ones put in their places, normalized ones as
  /// fractions. Not checked for being finite.
  [[nodiscard]] std::vector<double> values(uint64_t accessor, size_t& components);
  /// Of an accessor of whole numbers.
  [[nodiscard]] std::vector<uint32_t> indices(uint64_t accessor);

 private:
  struct Numbers;
  std::span<const unsigned char> buffer(uint64_t index);
  Numbers located(uint64_t view, uint64_t offset, uint64_t count, uint64_t componentType, size_t components,
                  bool tight);
  std::vector<unsigned char> external(const std::string& uri) const;

  std::filesystem::path folder_;
  std::vector<unsigned char> content_;
  std::span<const unsigned char> chunk_;  // the binary one
  bool binary_ = false;
  Json root_;
  std::vector<std::optional<std::vector<unsigned char>>> buffers_;
};

}  // namespace argil::io::reader
