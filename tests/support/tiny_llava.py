"""A LLaVA with random weights in the real format whose last layer is bent to say one word.

It takes the way of every picture and question through a real server and costs nothing; what it
says is known beforehand, which a random model's nonsense is not.
"""

from pathlib import Path

SPECIAL = ("<unk>", "<s>", "</s>", "<pad>", "<image>")
WORDS = (*(str(number) for number in range(1, 13)), "none")
PATCH, SIDE, HIDDEN = 14, 28, 32


def write_tiny_llava(folder: Path, says: str) -> Path:
    """Write model and processor; the model answers everything with ``says``, one of ``WORDS``."""
    import torch
    from transformers import (
        CLIPImageProcessorPil,
        CLIPVisionConfig,
        LlamaConfig,
        LlavaConfig,
        LlavaForConditionalGeneration,
        LlavaProcessor,
    )

    tokenizer = _tokenizer()
    ids = tokenizer.get_vocab()
    sizes = {"hidden_size": HIDDEN, "intermediate_size": 64, "num_hidden_layers": 2}
    config = LlavaConfig(
        vision_config=CLIPVisionConfig(
            **sizes, num_attention_heads=4, image_size=SIDE, patch_size=PATCH, projection_dim=HIDDEN
        ),
        text_config=LlamaConfig(
            **sizes,
            num_attention_heads=4,
            vocab_size=len(ids),
            max_position_embeddings=2048,
            bos_token_id=ids["<s>"],
            eos_token_id=ids["</s>"],
            pad_token_id=ids["<pad>"],
        ),
        image_token_id=ids["<image>"],
        image_seq_length=(SIDE // PATCH) ** 2,
    )
    torch.manual_seed(0)
    model = LlavaForConditionalGeneration(config)
    with torch.no_grad():
        model.get_input_embeddings().weight[:, 0] = 10.0  # what is in every token, ...
        model.get_output_embeddings().weight.mul_(0.01)
        model.get_output_embeddings().weight[ids[says], 0] = 10.0  # ... is heard as this word
    model.save_pretrained(folder)
    LlavaProcessor(
        CLIPImageProcessorPil(
            size={"shortest_edge": SIDE}, crop_size={"height": SIDE, "width": SIDE}
        ),
        tokenizer,
        patch_size=PATCH,
        vision_feature_select_strategy="default",
        num_additional_image_tokens=1,
        chat_template=_TEMPLATE,
    ).save_pretrained(folder)
    return folder


_TEMPLATE = (
    "{% for m in messages %}{% if m['content'] is string %}{{ m['content'] }} "
    "{% else %}{% for part in m['content'] %}"
    "{% if part['type'] == 'text' %}{{ part['text'] }} {% else %}<image> {% endif %}"
    "{% endfor %}{% endif %}{% endfor %}"
)


def _tokenizer():
    from tokenizers import Tokenizer, models, pre_tokenizers
    from transformers import PreTrainedTokenizerFast

    vocabulary = {word: i for i, word in enumerate((*SPECIAL, *WORDS))}
    words = Tokenizer(models.WordLevel(vocabulary, unk_token="<unk>"))
    words.pre_tokenizer = pre_tokenizers.Whitespace()
    words.add_special_tokens(list(SPECIAL))
    return PreTrainedTokenizerFast(
        tokenizer_object=words,
        unk_token="<unk>",
        bos_token="<s>",
        eos_token="</s>",
        pad_token="<pad>",
        extra_special_tokens={"image_token": "<image>"},
    )
