// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// FCL's trees of bounding volumes, with what its Python package does not tell: how often two volumes and how
// often two triangles were compared. The tree is FCL's own, built by its defaults; so is the traversal.

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/utility.h>
#include <fcl/narrowphase/detail/traversal/collision/mesh_collision_traversal_node.h>
#include <fcl/narrowphase/detail/traversal/collision_node.h>

#include <algorithm>
#include <cstdint>
#include <limits>

namespace {

using Request = fcl::CollisionRequest<double>;
using Result = fcl::CollisionResult<double>;
using Move = fcl::Transform3<double>;

struct Tests {
  int64_t volumes, triangles;
};

template <typename Volume, typename Node>
struct Tree {
  using Model = fcl::BVHModel<Volume>;

  static void *load(const double *vertices, int64_t count) {
    auto *model = new Model;
    model->beginModel(static_cast<int>(count), static_cast<int>(3 * count));
    for (int64_t i = 0; i < count; ++i, vertices += 9) {
      model->addTriangle({vertices[0], vertices[1], vertices[2]}, {vertices[3], vertices[4], vertices[5]},
                         {vertices[6], vertices[7], vertices[8]});
    }
    model->endModel();
    return model;
  }

  static void release(void *model) { delete static_cast<Model *>(model); }

  // Finds all pairs that collide; writes the first `room` of them, (number in A, number in B).
  static int64_t collide(void *a, void *b, int32_t *pairs, int64_t room, Tests *tests) {
    // Without contact points each pair is found once.
    Request request(std::numeric_limits<std::size_t>::max(), false);
    Result result;
    Move here_a = Move::Identity(), here_b = Move::Identity();
    Node node;
    if (!fcl::detail::initialize(node, *static_cast<Model *>(a), here_a, *static_cast<Model *>(b), here_b, request,
                                 result)) {
      return -1;
    }
    node.enable_statistics = tests != nullptr;
    fcl::detail::collide(&node);
    const int64_t found = static_cast<int64_t>(result.numContacts());
    for (int64_t i = 0; i < std::min(found, room); ++i) {
      const auto &contact = result.getContact(static_cast<std::size_t>(i));
      pairs[2 * i] = static_cast<int32_t>(contact.b1);
      pairs[2 * i + 1] = static_cast<int32_t>(contact.b2);
    }
    if (tests != nullptr) *tests = {node.num_bv_tests, node.num_leaf_tests};
    return found;
  }
};

using Obb = Tree<fcl::OBB<double>, fcl::detail::MeshCollisionTraversalNodeOBB<double>>;
using ObbRss = Tree<fcl::OBBRSS<double>, fcl::detail::MeshCollisionTraversalNodeOBBRSS<double>>;
using Aabb = Tree<fcl::AABB<double>, fcl::detail::MeshCollisionTraversalNode<fcl::AABB<double>>>;

}  // namespace

// Kinds of volumes: 0 OBB, 1 OBBRSS, 2 AABB.
extern "C" {

void *triaxis_load(int kind, const double *vertices, int64_t count) {
  return kind == 0 ? Obb::load(vertices, count)
                   : kind == 1 ? ObbRss::load(vertices, count) : Aabb::load(vertices, count);
}

void triaxis_free(int kind, void *model) {
  kind == 0 ? Obb::release(model) : kind == 1 ? ObbRss::release(model) : Aabb::release(model);
}

int64_t triaxis_ask(int kind, void *a, void *b, int32_t *pairs, int64_t room, int64_t *tests) {
  auto *counted = reinterpret_cast<Tests *>(tests);
  return kind == 0   ? Obb::collide(a, b, pairs, room, counted)
         : kind == 1 ? ObbRss::collide(a, b, pairs, room, counted)
                     : Aabb::collide(a, b, pairs, room, counted);
}
}
