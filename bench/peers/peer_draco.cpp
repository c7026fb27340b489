// peer_draco INPUT.ply OUTPUT.drc DECODED.ply BITS: codes the positions of a mesh as `draco_encoder
// -cl 10 -qp BITS` does, decodes the file again, and says as JSON how many bytes it has.
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>

#include <cstdlib>
#include <exception>

#include "ply_arrays.h"

namespace {

void check(const draco::Status& status) {
  if (!status.ok()) throw std::runtime_error("Draco: " + status.error_msg_string());
}

void build(const peers::MeshArrays& arrays, draco::Mesh& mesh) {
  const auto vertices = static_cast<std::uint32_t>(arrays.coordinates.size() / 3);
  mesh.set_num_points(vertices);
  draco::GeometryAttribute position;
  position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false,
                3 * sizeof(float), 0);
  draco::PointAttribute& values = *mesh.attribute(mesh.AddAttribute(position, true, vertices));
  for (std::uint32_t i = 0; i < vertices; ++i) {
    values.SetAttributeValue(draco::AttributeValueIndex(i), &arrays.coordinates[3 * i]);
  }
  for (std::size_t i = 0; i < arrays.corners.size(); i += 3) {
    mesh.AddFace({draco::PointIndex(arrays.corners[i]), draco::PointIndex(arrays.corners[i + 1]),
                  draco::PointIndex(arrays.corners[i + 2])});
  }
}

peers::MeshArrays to_arrays(const draco::Mesh& mesh) {
  const draco::PointAttribute* position =
      mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (position == nullptr) throw std::runtime_error("Draco decoded no positions");
  peers::MeshArrays arrays;
  arrays.coordinates.resize(3 * std::size_t{mesh.num_points()});
  for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
    position->GetMappedValue(draco::PointIndex(i), &arrays.coordinates[3 * std::size_t{i}]);
  }
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
    for (const draco::PointIndex corner : mesh.face(draco::FaceIndex(f))) {
      arrays.corners.push_back(corner.value());
    }
  }
  return arrays;
}

void encode(const peers::MeshArrays& arrays, int bits, draco::EncoderBuffer& bytes) {
  draco::Mesh mesh;
  build(arrays, mesh);
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  encoder.SetSpeedOptions(0, 0);  // -cl 10
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  check(encoder.EncodeMeshToBuffer(mesh, &bytes));
}

peers::MeshArrays decode(const draco::EncoderBuffer& bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  auto mesh = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  check(mesh.status());
  return to_arrays(*mesh.value());
}

void write_bytes(const char* path, const draco::EncoderBuffer& bytes) {
  const peers::FilePointer file = peers::open_file(path, "wb");
  if (std::fwrite(bytes.data(), 1, bytes.size(), file.get()) != bytes.size() ||
      std::fflush(file.get()) != 0) {
    throw std::runtime_error(std::string(path) + ": writing failed");
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int bits = argc == 5 ? std::atoi(argv[4]) : 0;
  if (bits < 1 || bits > 30) {
    std::fprintf(stderr, "usage: peer_draco INPUT.ply OUTPUT.drc DECODED.ply BITS\n");
    return 2;
  }
  try {
    draco::EncoderBuffer bytes;
    encode(peers::read_ply(argv[1]), bits, bytes);
    write_bytes(argv[2], bytes);
    const peers::MeshArrays decoded = decode(bytes);
    peers::write_ply(argv[3], decoded);
    std::printf("{\"bytes\": %zu, \"vertices\": %zu, \"faces\": %zu}\n", bytes.size(),
                decoded.coordinates.size() / 3, decoded.corners.size() / 3);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "peer_draco: %s\n", error.what());
    return 1;
  }
}
