// bench-lib3mf RAW OUT: lib3mf writes a mesh as 3MF, in a process of its own so that argil does not need lib3mf and its
// memory can be told. RAW holds two 32-bit counts, three 32-bit floats a vertex, three 32-bit indices a triangle.
// Prints seconds of the writing alone, and the peak of its memory in kB.

#include <Model/COM/NMR_DLLInterfaces.h>
#include <sys/resource.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <vector>

int main(int count, char** arguments) {
  using namespace NMR;
  if (count != 3) return 2;
  std::ifstream raw(arguments[1], std::ios::binary);
  const auto read = [&](auto* to, size_t number) {
    raw.read(reinterpret_cast<char*>(to), static_cast<std::streamsize>(number * sizeof *to));
  };
  std::array<uint32_t, 2> counts{};
  read(counts.data(), 2);
  std::vector<MODELMESHVERTEX> positions(counts[0]);
  std::vector<MODELMESHTRIANGLE> triangles(counts[1]);
  read(positions.data(), positions.size());
  read(triangles.data(), triangles.size());
  PLib3MFModel* model = nullptr;
  PLib3MFModelMeshObject* mesh = nullptr;
  PLib3MFModelBuildItem* item = nullptr;
  PLib3MFModelWriter* writer = nullptr;
  const bool ready =
      raw && lib3mf_createmodel(&model) == LIB3MF_OK && lib3mf_model_addmeshobject(model, &mesh) == LIB3MF_OK &&
      lib3mf_meshobject_setgeometry(mesh, positions.data(), counts[0], triangles.data(), counts[1]) == LIB3MF_OK &&
      lib3mf_model_addbuilditem(model, mesh, nullptr, &item) == LIB3MF_OK &&
      lib3mf_model_querywriter(model, "3mf", &writer) == LIB3MF_OK;
  if (!ready) return 1;
  const auto start = std::chrono::steady_clock::now();
  if (lib3mf_writer_writetofileutf8(writer, arguments[2]) != LIB3MF_OK) return 1;
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("%.6f %ld\n", took.count(), usage.ru_maxrss);
  return 0;
}
