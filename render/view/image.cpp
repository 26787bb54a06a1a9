#include "render/view/image.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "clay/base/error.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#include <stb_image_write.h>

namespace argil::render {
namespace {

/// Closes and removes the temporary file unless the rename took it.
struct TemporaryFile {
  std::string path;
  int descriptor = -1;
  bool kept = false;

  ~TemporaryFile() {
    if (descriptor >= 0) ::close(descriptor);
    if (!kept) ::unlink(path.c_str());
  }
};

[[noreturn]] void failed(const std::string& path, const char* what, int code) {
  throw Error("cannot " + std::string(what) + " the picture '" + path + "': " + std::strerror(code) +
                  "; choose a folder that exists, can be written and has room",
              Error::Kind::work);
}

}  // namespace

std::vector<uint8_t> encodePng(const Image& image) {
  if (image.width <= 0 || image.height <= 0 || image.rgba.size() != size_t(image.width) * size_t(image.height) * 4) {
    throw Error("the picture has no pixels to write", Error::Kind::work);
  }
  std::vector<uint8_t> bytes;
  const auto append = [](void* context, void* data, int size) {
    auto* target = static_cast<std::vector<uint8_t>*>(context);
    const auto* source = static_cast<const uint8_t*>(data);
    target->insert(target->end(), source, source + size);
  };
  if (!stbi_write_png_to_func(append, &bytes, image.width, image.height, 4, image.rgba.data(), image.width * 4)) {
    throw Error("the picture could not be packed as PNG; free some memory and try again", Error::Kind::work);
  }
  return bytes;
}

void writePng(const Image& image, const std::string& path) {
  const std::vector<uint8_t> bytes = encodePng(image);
  TemporaryFile file{path + ".part" + std::to_string(::getpid())};
  file.descriptor = ::open(file.path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file.descriptor < 0) {
    const int code = errno;
    file.kept = true;  // not ours
    failed(path, "create", code);
  }
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t count = ::write(file.descriptor, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) failed(path, "write", errno);
    done += size_t(count);
  }
  if (::fsync(file.descriptor) != 0) failed(path, "flush", errno);
  if (::rename(file.path.c_str(), path.c_str()) != 0) failed(path, "replace", errno);
  file.kept = true;
}

}  // namespace argil::render
