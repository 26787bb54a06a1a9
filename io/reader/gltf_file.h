#pragma once
// A .gltf or .glb file opened: its JSON, its buffers, numbers through its accessors. Nothing that the file says is
// believed.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace argil::io::reader {

class GltfFile {
 public:
  /// The numbers of an accessor, taken from the file's bytes when they are asked for: what is read once needs no copy.
  /// Holds as long as its file.
  class Numbers {
   public:
    [[nodiscard]] uint64_t count() const { return count_; }
    [[nodiscard]] size_t components() const { return components_; }
    /// All components of an element below count(), normalized ones as fractions. Not checked for being finite.
    void get(uint64_t element, double* to) const;
    /// Of an accessor of whole numbers.
    [[nodiscard]] uint32_t index(uint64_t element) const;

   private:
    friend class GltfFile;
    const unsigned char* first_ = nullptr;
    size_t stride_ = 0, components_ = 0;
    uint64_t count_ = 0, type_ = 0;
    bool normalized_ = false;
    std::vector<std::pair<uint64_t, const unsigned char*>> changed_;  // Of a sparse accessor: rising elements.
  };

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
  /// The bytes of an image's file: a view of a buffer, a data URI, or a file in the folder. Throws Error.
  [[nodiscard]] std::vector<unsigned char> image(uint64_t index);
  /// An accessor of 2 to 4 components, sparse ones put in their places.
  [[nodiscard]] Numbers values(uint64_t accessor);
  /// Of whole numbers.
  [[nodiscard]] Numbers indices(uint64_t accessor);

 private:
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
