#include "plugins/runner/runner.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <utility>

#include "plugins/runner/futex.h"

namespace argil::plugin {

void put(char (&to)[kMostText], const char* text) noexcept {
  size_t n = ::strnlen(text, kMostText - 1);
  if (n == kMostText - 1)
    while (n > 0 && (static_cast<unsigned char>(text[n]) & 0xc0) == 0x80) --n;
  std::memcpy(to, text, n);
  to[n] = '\0';
}

void answer(Channel& channel) noexcept {
  channel.answered.fetch_add(1);
  wakeAll(channel.answered);
}

void Runner::sleepUntilAsked() {
  while (channel_.asked.load() == done_) sleepWhile(channel_.asked, done_, -1);
  ++done_;
}

void Runner::serve() {
  for (;;) {
    sleepUntilAsked();
    channel_.text[0] = '\0';
    channel_.refusal = Refusal::none;
    const argil_status status = work();
    channel_.upcall = Upcall::none;
    channel_.status = status == kAsking ? ARGIL_FAILED : status;
    answer(channel_);
  }
}

// Stops for an answer in the midst of work.
uint64_t Runner::ask(Upcall what, uint64_t first, uint64_t count) {
  channel_.upcall = what;
  channel_.first = first;
  channel_.count = count;
  channel_.status = kAsking;
  answer(channel_);
  sleepUntilAsked();
  return channel_.result;
}

argil_status Runner::work() {
  switch (channel_.command) {
    case Command::none:
      return ARGIL_OK;
    case Command::describe:
      return describe();
    case Command::beginStroke:
      return beginStroke();
    case Command::bricks:
      return bricks();
    case Command::endStroke:
      endStroke();
      return ARGIL_OK;
    case Command::beginExport:
      return beginExport();
    case Command::exportObject:
    case Command::exportVertices:
    case Command::exportTriangles:
      return exportBlock();
    case Command::endExport:
      return endExport();
    case Command::import:
      return import();
    case Command::operate:
      return operate();
    case Command::beginGuide:
      return beginGuide();
    case Command::endGuide:
      endGuide();
      return ARGIL_OK;
    case Command::texture:
      return texture();
    case Command::beginDevice:
      return beginDevice();
    case Command::endDevice:
      endDevice();
      return ARGIL_OK;
  }
  return ARGIL_FAILED;
}

template <class Thing>
const Thing* Runner::asked(const Thing* thing) {
  if (thing == nullptr) channel_.refusal = Refusal::unknownThing;
  return thing;
}

argil_status Runner::describe() {
  const auto tell = [&](uint32_t flags, uint32_t margin, uint32_t count, const char* const* parameters) {
    channel_.flags = flags;
    channel_.margin = margin;
    channel_.parameterCount = count;
    for (uint32_t i = 0; parameters != nullptr && i < std::min(count, kMostParameters); ++i)
      put(channel_.parameterIds[i], parameters[i] != nullptr ? parameters[i] : "");
    return ARGIL_OK;
  };
  switch (channel_.kind) {
    case ThingKind::brush:
      if (const argil_brush* brush = asked(library_.brush(channel_.thing)))
        return tell(brush->flags, brush->margin, brush->parameter_count, brush->parameters);
      break;
    case ThingKind::exporter:
      if (asked(library_.exporter(channel_.thing)) != nullptr) return tell(0, 0, 0, nullptr);
      break;
    case ThingKind::importer:
      if (asked(library_.importer(channel_.thing)) != nullptr) return tell(0, 0, 0, nullptr);
      break;
    case ThingKind::operation:
      if (const argil_operation* operation = asked(library_.operation(channel_.thing)))
        return tell(0, 0, operation->parameter_count, operation->parameters);
      break;
    case ThingKind::guide:
      if (const argil_guide* guide = asked(library_.guide(channel_.thing)))
        return tell(0, 0, guide->parameter_count, guide->parameters);
      break;
    case ThingKind::texture:
      if (const argil_texture* texture = asked(library_.texture(channel_.thing)))
        return tell(0, 0, texture->parameter_count, texture->parameters);
      break;
    case ThingKind::device:
      if (asked(library_.device(channel_.thing)) != nullptr) return tell(0, 0, 0, nullptr);
      break;
  }
  return ARGIL_FAILED;
}

argil_status Runner::beginStroke() {
  endStroke();
  const argil_brush* brush = asked(library_.brush(channel_.thing));
  if (brush == nullptr) return ARGIL_FAILED;
  argil_stroke stroke = channel_.stroke;
  stroke.parameters = channel_.parameters;
  if (brush->begin != nullptr) {
    stroke_ = brush->begin(&stroke);
    if (stroke_ == nullptr && brush->end != nullptr) return ARGIL_FAILED;
  }
  brush_ = brush;
  return ARGIL_OK;
}

void Runner::endStroke() {
  if (brush_ != nullptr && brush_->size >= offsetof(argil_brush, end) + sizeof(brush_->end) && brush_->end != nullptr)
    brush_->end(stroke_);
  brush_ = nullptr;
  stroke_ = nullptr;
}

void Runner::waitUntilFilled(uint32_t count) {
  constexpr int64_t kSoonNs = 50'000;
  for (uint32_t filled = channel_.filled.load(); filled < count; filled = channel_.filled.load()) {
    if (changesSoon(channel_.filled, filled, kSoonNs)) continue;
    channel_.sleepers.fetch_add(1);
    sleepWhile(channel_.filled, filled, -1);
    channel_.sleepers.fetch_sub(1);
  }
}

argil_status Runner::bricks() {
  if (brush_ == nullptr) return ARGIL_FAILED;
  const BatchPlace& place = channel_.batch;
  std::atomic<argil_status> worst{ARGIL_OK};
  const auto range = [&](uint32_t from, uint32_t to) {
    waitUntilFilled(to);
    argil_batch batch{};
    batch.size = sizeof batch;
    batch.image_count = channel_.imageCount;
    batch.images = channel_.images;
    batch.count = to - from;
    batch.margin = place.margin;
    batch.coords = window<const int32_t[3]>(place.coords) + from;
    batch.phi = window<const float>(place.phi) + size_t{from} * place.brick;
    batch.brick = place.brick;
    batch.plane = place.plane;
    batch.row = place.row;
    batch.weight = window<const float>(place.weight) + size_t{from} * 512;
    batch.out = window<float>(place.out) + size_t{from} * 512;
    if (const argil_status status = brush_->bricks(stroke_, &batch); status != ARGIL_OK) worst.store(status);
  };
  constexpr uint32_t kAtLeast = 8;  // bricks that are worth a thread's while
  workers_.run(place.count, (brush_->flags & ARGIL_BRUSH_SERIAL) != 0 ? place.count : kAtLeast, range);
  return worst.load();
}

argil_status Runner::beginExport() {
  exporter_ = asked(library_.exporter(channel_.thing));
  if (exporter_ == nullptr) return ARGIL_FAILED;
  export_ = {};
  export_.size = sizeof export_;
  export_.object_count = channel_.objectCount;
  export_.frame = channel_.frame;
  export_.frame_count = channel_.frameCount;
  export_.self = this;
  export_.write = [](void* self, const void* bytes, uint64_t count) {
    auto* runner = static_cast<Runner*>(self);
    for (const auto* from = static_cast<const std::byte*>(bytes); count > 0;) {
      const uint64_t some = std::min(count, kMostBytesAtOnce);
      std::memcpy(runner->window<std::byte>(), from, some);
      if (runner->ask(Upcall::write, 0, some) == 0) return false;
      from += some;
      count -= some;
    }
    return true;
  };
  exporting_ = exporter_->begin(&export_);
  return exporting_ == nullptr && exporter_->end != nullptr ? ARGIL_FAILED : ARGIL_OK;
}

argil_status Runner::exportBlock() {
  if (exporter_ == nullptr) return ARGIL_FAILED;
  const auto count = static_cast<uint32_t>(channel_.count);
  if (channel_.command == Command::exportObject) {
    const argil_object object{sizeof(argil_object), channel_.object.colours != 0, {},
                              channel_.object.name, channel_.object.vertices,     channel_.object.triangles};
    return exporter_->object(exporting_, &object);
  }
  // What it writes goes by the window too: the block is taken out of it first.
  const size_t bytes = channel_.command == Command::exportVertices ? sizeof(double[3]) : sizeof(uint32_t[3]);
  const bool colours = channel_.first != 0;
  static std::byte block[kMostElements * (sizeof(double[3]) + 4)];
  std::memcpy(block, window<std::byte>(), count * (bytes + (colours ? 4 : 0)));
  if (channel_.command == Command::exportVertices)
    return exporter_->vertices(exporting_, reinterpret_cast<const double*>(block),
                               colours ? reinterpret_cast<const uint8_t*>(block + count * bytes) : nullptr, count);
  return exporter_->triangles(exporting_, reinterpret_cast<const uint32_t*>(block), count);
}

argil_status Runner::endExport() {
  if (exporter_ == nullptr) return ARGIL_FAILED;
  const argil_exporter* exporter = std::exchange(exporter_, nullptr);
  return exporter->end != nullptr ? exporter->end(exporting_, channel_.count != 0) : ARGIL_OK;
}

// In blocks of kMostElements.
bool Runner::giveMesh(Upcall what, const void* items, size_t bytesEach, const uint8_t* colours, uint64_t count) {
  const auto* from = static_cast<const std::byte*>(items);
  for (uint64_t done = 0; done < count;) {
    const uint64_t some = std::min<uint64_t>(count - done, kMostElements);
    std::memcpy(window<std::byte>(), from + done * bytesEach, some * bytesEach);
    if (colours != nullptr) std::memcpy(window<std::byte>(some * bytesEach), colours + done * 4, some * 4);
    if (ask(what, colours != nullptr, some) == 0) return false;
    done += some;
  }
  return true;
}

argil_status Runner::import() {
  const argil_importer* importer = asked(library_.importer(channel_.thing));
  if (importer == nullptr) return ARGIL_FAILED;
  argil_import file{};
  file.size = sizeof file;
  file.file_bytes = channel_.fileBytes;
  file.self = this;
  file.read = [](void* self, uint64_t offset, void* bytes, uint64_t count) {
    auto* runner = static_cast<Runner*>(self);
    uint64_t done = 0;
    while (done < count) {
      const uint64_t some = std::min(count - done, kMostBytesAtOnce);
      const uint64_t got = std::min(runner->ask(Upcall::read, offset + done, some), some);
      std::memcpy(static_cast<std::byte*>(bytes) + done, runner->window<std::byte>(), got);
      done += got;
      if (got < some) break;
    }
    return done;
  };
  file.object = [](void* self, const argil_object* object) {
    auto* runner = static_cast<Runner*>(self);
    runner->channel_.object.vertices = object->vertex_count;
    runner->channel_.object.triangles = object->triangle_count;
    runner->channel_.object.colours = object->has_colours;
    put(runner->channel_.object.name, object->name != nullptr ? object->name : "");
    return runner->ask(Upcall::object, 0, 0) != 0;
  };
  file.vertices = [](void* self, const double* positions, const uint8_t* colours, uint32_t count) {
    return static_cast<Runner*>(self)->giveMesh(Upcall::vertices, positions, sizeof(double[3]), colours, count);
  };
  file.triangles = [](void* self, const uint32_t* corners, uint32_t count) {
    return static_cast<Runner*>(self)->giveMesh(Upcall::triangles, corners, sizeof(uint32_t[3]), nullptr, count);
  };
  return importer->run(&file);
}

argil_status Runner::beginGuide() {
  endGuide();
  const argil_guide* guide = asked(library_.guide(channel_.thing));
  if (guide == nullptr) return ARGIL_FAILED;
  guiding_ = guide->begin(channel_.parameters);
  if (guiding_ == nullptr && guide->end != nullptr) return ARGIL_FAILED;
  guide_ = guide;
  guideEnds_.store(false);
  guideThread_ = std::thread([this] {
    const auto period = std::chrono::nanoseconds(1'000'000'000 / std::clamp(guide_->rate_hz, 10u, 1000u));
    auto next = std::chrono::steady_clock::now();
    argil_hand hand{};
    hand.size = sizeof hand;
    argil_local_model model{};
    model.size = sizeof model;
    for (uint64_t seen = 0; !guideEnds_.load();) {
      // Without a servo that feels it there is nothing to say.
      if (channel_.hand.load(hand, seen) && guide_->update(guiding_, &hand, &model) == ARGIL_OK)
        channel_.model.store(model);
      next = std::max(next + period, std::chrono::steady_clock::now());
      std::this_thread::sleep_until(next);
    }
  });
  return ARGIL_OK;
}

void Runner::endGuide() {
  if (guide_ == nullptr) return;
  guideEnds_.store(true);
  guideThread_.join();
  if (guide_->size >= offsetof(argil_guide, end) + sizeof(guide_->end) && guide_->end != nullptr) guide_->end(guiding_);
  guide_ = nullptr;
}

argil_status Runner::beginDevice() {
  endDevice();
  const argil_device* device = asked(library_.device(channel_.thing));
  if (device == nullptr) return ARGIL_FAILED;
  held_ = device->begin();
  const bool ends = device->size >= offsetof(argil_device, end) + sizeof(device->end) && device->end != nullptr;
  if (held_ == nullptr && ends) return ARGIL_FAILED;
  device_ = device;
  deviceEnds_.store(false);
  deviceThread_ = std::thread([this] { exchangeUntilEnd(); });
  return ARGIL_OK;
}

// Argil asks for each exchange. When it does not, nobody holds the force back: the motors get zero.
void Runner::exchangeUntilEnd() {
  constexpr int64_t kSilentNs = 100'000'000;
  const double zero[3] = {0, 0, 0};
  Channel::DeviceSaid said{};
  std::array<double, 3> force{};
  uint64_t seen = 0;
  for (uint32_t done = channel_.turned.load(); !deviceEnds_.load();) {
    uint32_t turn = channel_.turn.load();
    if (turn == done) {
      sleepWhile(channel_.turn, done, kSilentNs);
      turn = channel_.turn.load();
    }
    said.state = {};
    said.state.size = sizeof said.state;
    if (turn == done) {
      (void)device_->exchange(held_, zero, &said.state);
      continue;
    }
    // A force that is being written is that of a later turn.
    if (!channel_.force.load(force, seen)) force = {};
    said.turn = done = turn;
    said.status = device_->exchange(held_, force.data(), &said.state);
    channel_.said.store(said);
    channel_.turned.store(turn);
    wakeAll(channel_.turned);
  }
}

void Runner::endDevice() {
  if (device_ == nullptr) return;
  deviceEnds_.store(true);
  deviceThread_.join();
  if (device_->size >= offsetof(argil_device, end) + sizeof(device_->end) && device_->end != nullptr)
    device_->end(held_);
  device_ = nullptr;
}

argil_status Runner::texture() {
  const argil_texture* texture = asked(library_.texture(channel_.thing));
  const auto count = static_cast<uint32_t>(std::min<uint64_t>(channel_.count, kMostElements));
  auto* places = window<float>();
  return texture == nullptr
             ? ARGIL_FAILED
             : texture->heights(channel_.parameters, places, places + count, places + 2 * size_t{count}, count);
}

argil_status Runner::operate() {
  const argil_operation* operation = asked(library_.operation(channel_.thing));
  if (operation == nullptr) return ARGIL_FAILED;
  // The channel's own go with the first question.
  float parameters[kMostParameters];
  std::memcpy(parameters, channel_.parameters, sizeof parameters);
  argil_work work{};
  work.size = sizeof work;
  work.band = channel_.stroke.band;
  work.voxel_mm = channel_.stroke.voxel_mm;
  std::memcpy(work.origin_mm, channel_.stroke.origin_mm, sizeof work.origin_mm);
  work.brick_count = channel_.count;
  work.parameter_count = channel_.stroke.parameter_count;
  work.parameters = parameters;
  work.self = this;
  work.bricks = [](void* self, uint64_t first, uint32_t count, int32_t* coords, float* phi) {
    auto* runner = static_cast<Runner*>(self);
    const uint64_t got = std::min<uint64_t>(runner->ask(Upcall::bricks, first, std::min(count, kMostBricks)),
                                            std::min(count, kMostBricks));
    std::memcpy(coords, runner->window<std::byte>(), got * sizeof(int32_t[3]));
    std::memcpy(phi, runner->window<std::byte>(kMostBricks * sizeof(int32_t[3])), got * sizeof(float[512]));
    return static_cast<uint32_t>(got);
  };
  work.brick = [](void* self, const int32_t* coord, float* phi) {
    auto* runner = static_cast<Runner*>(self);
    std::copy_n(coord, 3, runner->channel_.coord);
    (void)runner->ask(Upcall::brick, 0, 0);
    std::memcpy(phi, runner->window<std::byte>(), sizeof(float[512]));
  };
  work.put = [](void* self, uint32_t count, const int32_t* coords, const float* phi) {
    auto* runner = static_cast<Runner*>(self);
    for (uint32_t done = 0; done < count;) {
      const uint32_t some = std::min(count - done, kMostBricks);
      std::memcpy(runner->window<std::byte>(), coords + 3 * size_t{done}, some * sizeof(int32_t[3]));
      std::memcpy(runner->window<std::byte>(kMostBricks * sizeof(int32_t[3])), phi + 512 * size_t{done},
                  some * sizeof(float[512]));
      if (runner->ask(Upcall::put, 0, some) == 0) return false;
      done += some;
    }
    return true;
  };
  return operation->run(&work);
}

}  // namespace argil::plugin
