#include "render/gpu/draw_list.h"

#include <algorithm>
#include <cstring>

namespace argil::render {
namespace {

constexpr uint32_t kPageCommands = 4096;
constexpr uint32_t kStride = sizeof(VkDrawIndexedIndirectCommand);

}  // namespace

void DrawList::nextPicture(size_t commands) {
  picture_ = (picture_ + 1) % kPictures;
  for (Page& page : pages_[picture_]) page.used = 0;
  for (std::vector<Page>& pages : pages_)
    while (pages.size() * kPageCommands < commands) addPage(pages);
}

void DrawList::addPage(std::vector<Page>& pages) {
  pages.push_back(
      {Buffer(gpu_, VkDeviceSize(kPageCommands) * kStride, VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, Buffer::Memory::upload),
       0});
}

uint64_t DrawList::draw(VkCommandBuffer buffer, const std::vector<VkDrawIndexedIndirectCommand>& commands) {
  uint64_t calls = 0;
  std::vector<Page>& pages = pages_[picture_];
  const uint32_t most = std::min(kPageCommands, gpu_.properties().limits.maxDrawIndirectCount);
  for (size_t done = 0; done < commands.size();) {
    auto page = std::find_if(pages.begin(), pages.end(), [](const Page& p) { return p.used < kPageCommands; });
    if (page == pages.end()) {
      addPage(pages);
      page = pages.end() - 1;
    }
    const auto count =
        uint32_t(std::min<size_t>({commands.size() - done, size_t(kPageCommands - page->used), size_t(most)}));
    std::memcpy(page->buffer.mapped() + size_t(page->used) * kStride, commands.data() + done, size_t(count) * kStride);
    vkCmdDrawIndexedIndirect(buffer, page->buffer.handle(), VkDeviceSize(page->used) * kStride, count, kStride);
    page->used += count;
    done += count;
    ++calls;
  }
  return calls;
}

uint64_t DrawList::bytes() const {
  uint64_t sum = 0;
  for (const auto& pages : pages_)
    for (const Page& page : pages) sum += page.buffer.size();
  return sum;
}

}  // namespace argil::render
