// SPDX-License-Identifier: Apache-2.0
// Private to the module: the numbers of fields in ONNX's messages (onnx.proto of ONNX 1.12 and later).
#pragma once

#include <cstdint>

namespace knuckle::onnx_fields {

using Number = std::uint32_t;

// ModelProto
inline constexpr Number kIrVersion = 1, kProducer = 2, kProducerVersion = 3, kModelDomain = 4,
                        kModelVersion = 5, kModelText = 6, kGraph = 7, kOpsetImport = 8, kModelMetadata = 14,
                        kTrainingInfo = 20, kFunctions = 25;
// OperatorSetIdProto
inline constexpr Number kOpsetDomain = 1, kOpsetVersion = 2;
// StringStringEntryProto
inline constexpr Number kEntryKey = 1, kEntryValue = 2;
// GraphProto
inline constexpr Number kNode = 1, kGraphName = 2, kInitializer = 5, kGraphText = 10, kInput = 11,
                        kOutput = 12, kValueInfo = 13, kQuantization = 14, kSparseInitializer = 15,
                        kGraphMetadata = 16;
// NodeProto
inline constexpr Number kNodeInput = 1, kNodeOutput = 2, kNodeName = 3, kOperation = 4, kAttribute = 5,
                        kNodeText = 6, kNodeDomain = 7, kOverload = 8, kNodeMetadata = 9;
// AttributeProto
inline constexpr Number kAttributeName = 1, kReal = 2, kInteger = 3, kText = 4, kTensor = 5, kReals = 7,
                        kIntegers = 8, kAttributeText = 13, kAttributeType = 20;
// TensorProto
inline constexpr Number kDims = 1, kDataType = 2, kRealData = 4, kIntegerData = 7, kTensorName = 8,
                        kRawData = 9, kTensorText = 12, kExternalData = 13, kDataLocation = 14,
                        kTensorMetadata = 16;
// ValueInfoProto, TypeProto, its Tensor, TensorShapeProto and its Dimension
inline constexpr Number kValueName = 1, kValueType = 2, kValueText = 3, kValueMetadata = 4, kTensorType = 1,
                        kTypeDenotation = 6, kElementType = 1, kShape = 2, kDimension = 1,
                        kDimensionValue = 1, kDimensionName = 2, kDimensionDenotation = 3;

// AttributeProto.AttributeType
inline constexpr std::int64_t kTypeReal = 1, kTypeInteger = 2, kTypeText = 3, kTypeTensor = 4, kTypeReals = 6,
                              kTypeIntegers = 7;

}  // namespace knuckle::onnx_fields
