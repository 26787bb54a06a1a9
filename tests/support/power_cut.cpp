#include "tests/support/power_cut.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <random>
#include <stdexcept>

namespace argil::failing {
namespace {

namespace fs = std::filesystem;
using Kind = TraceOp::Kind;

uint64_t mixed(uint64_t a, uint64_t b) {
  uint64_t z = a * 0x9e3779b97f4a7c15u + b + 0x632be59bd9b4e019u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

void applyData(std::string& bytes, const TraceOp& op) {
  if (op.kind == Kind::resize) {
    bytes.resize(op.at);
    return;
  }
  if (bytes.size() < op.at + op.bytes.size()) bytes.resize(op.at + op.bytes.size());
  std::copy(op.bytes.begin(), op.bytes.end(), bytes.begin() + static_cast<std::ptrdiff_t>(op.at));
}

void applyEntry(std::map<std::string, uint32_t>& entries, const TraceOp& op) {
  const auto remove = [&](const std::string& name) {
    const auto found = entries.find(name);
    if (found != entries.end() && found->second == op.node) entries.erase(found);
  };
  if (op.kind == Kind::create || op.kind == Kind::makeFolder) {
    entries[op.name] = op.node;
  } else {
    remove(op.name);
    if (op.kind == Kind::rename) entries[op.to] = op.node;
  }
}

}  // namespace

CutDisk::CutDisk(const Trace& trace, Ignores ignores)
    : trace_(trace), ignores_(std::move(ignores)), nodes_(trace.nodes) {
  for (uint32_t i = 0; i < trace.before.size(); ++i) {
    nodes_[i].folder = trace.before[i].folder;
    nodes_[i].bytes = trace.before[i].bytes;
    if (i > 0) nodes_[trace.before[i].parent].entries[trace.before[i].name] = i;
  }
}

void CutDisk::advance(size_t ops) {
  for (; at_ < ops; ++at_) {
    const TraceOp& op = trace_.ops[at_];
    switch (op.kind) {
      case Kind::note:
        break;
      case Kind::write:
      case Kind::resize:
        nodes_[op.node].since.push_back(&op);
        break;
      case Kind::makeFolder:
        nodes_[op.node].folder = true;
        [[fallthrough]];
      case Kind::create:
      case Kind::rename:
      case Kind::unlink:
        nodes_[op.folder].since.push_back(&op);
        break;
      case Kind::flush: {
        if (ignores_ && ignores_(trace_, at_)) break;
        Node& node = nodes_[op.node];
        for (const TraceOp* each : node.since) {
          if (node.folder)
            applyEntry(node.entries, *each);
          else
            applyData(node.bytes, *each);
        }
        node.since.clear();
      }
    }
  }
}

std::string CutDisk::content(const Node& node, Loss loss, uint64_t seed) {
  std::string bytes = node.bytes;
  if (loss == Loss::all || node.since.empty()) return bytes;
  std::mt19937_64 random(seed);
  const auto below = [&](size_t n) { return size_t(random() % n); };
  enum { everything, none, first, operations, sectors, pages };
  const size_t how = loss == Loss::nothing ? size_t(everything) : below(6);
  if (how == none) return bytes;
  std::string whole = bytes;  // its length when all had come
  for (const TraceOp* op : node.since) applyData(whole, *op);
  if (how == everything) return whole;
  const size_t grain = how == pages ? 4096 : 512;
  const size_t firsts = how == first ? below(node.since.size()) : node.since.size();
  std::vector<bool> came(whole.size() / 512 + 1, false);  // beyond what was flushed
  for (size_t i = 0; i <= firsts && i < node.since.size(); ++i) {
    const TraceOp& op = *node.since[i];
    const bool torn = how == sectors || how == pages || (how == first && i == firsts);
    if (how == operations && below(2) == 0) continue;
    if (op.kind == Kind::resize) {
      if (!torn || below(2) == 0) bytes.resize(op.at);
      continue;
    }
    for (size_t from = 0; from < op.bytes.size();) {
      const size_t sector = (op.at + from) / grain, to = std::min(op.bytes.size(), (sector + 1) * grain - op.at);
      if (!torn || below(2) == 0) {
        if (bytes.size() < op.at + to) bytes.resize(op.at + to);
        std::copy(op.bytes.begin() + std::ptrdiff_t(from), op.bytes.begin() + std::ptrdiff_t(to),
                  bytes.begin() + std::ptrdiff_t(op.at + from));
        for (size_t at = op.at + from; at < op.at + to; at += 512) {
          if (at / 512 < came.size()) came[at / 512] = true;
        }
      }
      from = to;
    }
  }
  // The length may have come without the bytes.
  const size_t grown = below(3);
  if (grown > 0 && bytes.size() < whole.size()) bytes.resize(whole.size());
  if (grown == 2) {
    for (size_t at = (node.bytes.size() + 511) / 512 * 512; at < bytes.size(); at += 512) {
      if (came[std::min(at / 512, came.size() - 1)]) continue;
      for (size_t i = at; i < std::min(bytes.size(), at + 512); ++i) bytes[i] = char(mixed(seed, i));
    }
  }
  return bytes;
}

std::map<std::string, uint32_t> CutDisk::entries(const Node& node, Loss loss, uint64_t seed) {
  std::map<std::string, uint32_t> entries = node.entries;
  if (loss == Loss::all) return entries;
  const bool inOrder = loss == Loss::nothing || mixed(seed, 1) % 2 == 0;
  const size_t count = loss == Loss::nothing ? node.since.size() : mixed(seed, 2) % (node.since.size() + 1);
  for (size_t i = 0; i < node.since.size(); ++i) {
    if (inOrder ? i < count : mixed(seed, 3 + i) % 2 == 0) applyEntry(entries, *node.since[i]);
  }
  return entries;
}

std::map<std::string, std::string> CutDisk::image(Loss loss, uint64_t seed) const {
  std::map<std::string, std::string> all;
  const auto visit = [&](const auto& self, uint32_t folder, const std::string& path) -> void {
    for (const auto& [name, node] : entries(nodes_[folder], loss, mixed(seed, folder))) {
      if (nodes_[node].folder) {
        all[path + name + "/"];
        self(self, node, path + name + "/");
      } else {
        all[path + name] = content(nodes_[node], loss, mixed(seed, node));
      }
    }
  };
  visit(visit, 0, "");
  return all;
}

void writeImage(const fs::path& folder, const std::map<std::string, std::string>& image) {
  for (const auto& each : fs::directory_iterator(folder)) fs::remove_all(each.path());
  for (const auto& [path, bytes] : image) {
    if (path.back() == '/') {
      fs::create_directory(folder / path.substr(0, path.size() - 1));
      continue;
    }
    std::ofstream out(folder / path, std::ios::binary);
    out.write(bytes.data(), std::streamsize(bytes.size()));
    if (!out.flush()) throw std::runtime_error("no room for " + path);
  }
}

std::map<std::string, std::string> readImage(const fs::path& folder) {
  std::map<std::string, std::string> image;
  for (const auto& each : fs::recursive_directory_iterator(folder)) {
    const std::string path = fs::relative(each.path(), folder).string();
    if (each.is_directory()) {
      image[path + "/"];
      continue;
    }
    std::ifstream in(each.path(), std::ios::binary);
    image[path].assign(std::istreambuf_iterator<char>(in), {});
  }
  return image;
}

}  // namespace argil::failing
